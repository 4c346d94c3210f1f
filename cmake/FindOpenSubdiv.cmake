# OpenSubdiv's CPU part: OpenSubdiv_FOUND and the target OpenSubdiv::CPU. The package's own file also asks for
# static libraries, which Debian does not ship.
find_path(OPENSUBDIV_INCLUDE_DIR opensubdiv/far/topologyRefiner.h)
find_library(OPENSUBDIV_LIBRARY NAMES osdCPU)
if(OPENSUBDIV_INCLUDE_DIR AND EXISTS ${OPENSUBDIV_INCLUDE_DIR}/opensubdiv/version.h)
  file(STRINGS ${OPENSUBDIV_INCLUDE_DIR}/opensubdiv/version.h lines REGEX "#define OPENSUBDIV_VERSION_(MAJOR|MINOR|PATCH) ")
  string(REGEX REPLACE "[^0-9;]" "" numbers "${lines}")
  list(JOIN numbers "." OPENSUBDIV_VERSION)
endif()
include(FindPackageHandleStandardArgs)
find_package_handle_standard_args(OpenSubdiv REQUIRED_VARS OPENSUBDIV_LIBRARY OPENSUBDIV_INCLUDE_DIR
                                  VERSION_VAR OPENSUBDIV_VERSION)
if(OpenSubdiv_FOUND AND NOT TARGET OpenSubdiv::CPU)
  add_library(OpenSubdiv::CPU UNKNOWN IMPORTED)
  set_target_properties(OpenSubdiv::CPU PROPERTIES IMPORTED_LOCATION "${OPENSUBDIV_LIBRARY}"
                        INTERFACE_INCLUDE_DIRECTORIES "${OPENSUBDIV_INCLUDE_DIR}")
endif()
