# The libraries of Open Cascade that write and read STEP and IGES: OpenCascade_FOUND and the target OpenCascade::Step.
# Named one by one: the package's own file asks for the whole of it, with visualisation.
find_path(OPENCASCADE_INCLUDE_DIR STEPControl_Writer.hxx PATH_SUFFIXES opencascade occt)
set(opencascade_libraries)
foreach(name TKIGES TKSTEP TKSTEPBase TKSTEPAttr TKSTEP209 TKXSBase TKShHealing TKTopAlgo TKGeomAlgo TKBRep TKGeomBase TKG3d TKG2d TKMath TKernel)
  find_library(OPENCASCADE_${name} NAMES ${name})
  mark_as_advanced(OPENCASCADE_${name})
  list(APPEND opencascade_libraries ${OPENCASCADE_${name}})
endforeach()
include(FindPackageHandleStandardArgs)
find_package_handle_standard_args(OpenCascade REQUIRED_VARS OPENCASCADE_TKIGES OPENCASCADE_TKSTEP OPENCASCADE_TKTopAlgo OPENCASCADE_TKBRep
                                                            OPENCASCADE_TKernel OPENCASCADE_INCLUDE_DIR)
if(OpenCascade_FOUND AND NOT TARGET OpenCascade::Step)
  add_library(OpenCascade::Step INTERFACE IMPORTED)
  target_include_directories(OpenCascade::Step SYSTEM INTERFACE "${OPENCASCADE_INCLUDE_DIR}")
  target_link_libraries(OpenCascade::Step INTERFACE ${opencascade_libraries})
endif()
