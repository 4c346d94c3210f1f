# Installs the library, its headers and a CMake package: find_package(batten) then batten::batten,
# or a single room such as batten::surfacing.
include(CMakePackageConfigHelpers)

get_property(rooms GLOBAL PROPERTY BATTEN_ROOMS)
set(room_targets)
foreach(room IN LISTS rooms)
  list(APPEND room_targets batten_${room})
endforeach()

install(TARGETS batten ${room_targets} EXPORT battenTargets
        ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR})
install(DIRECTORY ${PROJECT_SOURCE_DIR}/src/batten DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}
        FILES_MATCHING PATTERN "*.hpp" PATTERN "*_detail.hpp" EXCLUDE)
install(EXPORT battenTargets NAMESPACE batten:: DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/batten)

configure_package_config_file(${PROJECT_SOURCE_DIR}/cmake/battenConfig.cmake.in
                              ${PROJECT_BINARY_DIR}/battenConfig.cmake
                              INSTALL_DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/batten)
write_basic_package_version_file(${PROJECT_BINARY_DIR}/battenConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/battenConfig.cmake ${PROJECT_BINARY_DIR}/battenConfigVersion.cmake
              ${PROJECT_SOURCE_DIR}/cmake/FindCHOLMOD.cmake ${PROJECT_SOURCE_DIR}/cmake/FindOpenSubdiv.cmake
              ${PROJECT_SOURCE_DIR}/cmake/FindOpenCascade.cmake
        DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/batten)
if(TARGET batten_program)
  install(TARGETS batten_program DESTINATION ${CMAKE_INSTALL_BINDIR})
endif()
