# What is installed, in components that become packages (BattenPackages.cmake): the program; the library with its headers, a
# CMake package (find_package(batten), then batten::batten or a single room such as batten::surfacing) and a pkg-config
# file; the Python package (python/CMakeLists.txt); what a desktop knows of the studio (apps/studio/desktop).
include(CMakePackageConfigHelpers)

get_property(rooms GLOBAL PROPERTY BATTEN_ROOMS)
set(room_targets)
foreach(room IN LISTS rooms)
  list(APPEND room_targets batten_${room})
endforeach()

install(TARGETS batten ${room_targets} EXPORT battenTargets
        ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT development)
install(DIRECTORY ${PROJECT_SOURCE_DIR}/src/batten DESTINATION ${CMAKE_INSTALL_INCLUDEDIR} COMPONENT development
        FILES_MATCHING PATTERN "*.hpp" PATTERN "*_detail.hpp" EXCLUDE)
install(EXPORT battenTargets NAMESPACE batten:: DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/batten COMPONENT development)

configure_package_config_file(${PROJECT_SOURCE_DIR}/cmake/battenConfig.cmake.in
                              ${PROJECT_BINARY_DIR}/battenConfig.cmake
                              INSTALL_DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/batten)
write_basic_package_version_file(${PROJECT_BINARY_DIR}/battenConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/battenConfig.cmake ${PROJECT_BINARY_DIR}/battenConfigVersion.cmake
              ${PROJECT_SOURCE_DIR}/cmake/FindCHOLMOD.cmake ${PROJECT_SOURCE_DIR}/cmake/FindOpenSubdiv.cmake
              ${PROJECT_SOURCE_DIR}/cmake/FindOpenCascade.cmake
        DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/batten COMPONENT development)

# A linker takes from a static library what is missing so far: the rooms from the last to the first.
list(REVERSE rooms)
list(TRANSFORM rooms PREPEND -lbatten_ OUTPUT_VARIABLE libraries)
list(JOIN libraries " " BATTEN_PC_LIBRARIES)
set(private_packages zlib libpng gmp)
set(private_libraries -losdCPU)
if(JPEG_FOUND)
  list(APPEND private_packages libjpeg)
endif()
if(CHOLMOD_FOUND)
  list(APPEND private_libraries -lcholmod)
endif()
if(OpenCascade_FOUND)
  get_target_property(step_libraries OpenCascade::Step INTERFACE_LINK_LIBRARIES)
  list(TRANSFORM step_libraries REPLACE ".*/lib(TK[A-Za-z0-9]*)[.].*" "-l\\1")
  list(APPEND private_libraries ${step_libraries})
endif()
list(JOIN private_packages " " BATTEN_PC_PRIVATE_PACKAGES)
list(JOIN private_libraries " " BATTEN_PC_PRIVATE_LIBRARIES)
file(RELATIVE_PATH BATTEN_PREFIX_FROM_PC /${CMAKE_INSTALL_LIBDIR}/pkgconfig /)
string(REGEX REPLACE "/$" "" BATTEN_PREFIX_FROM_PC "${BATTEN_PREFIX_FROM_PC}")
configure_file(${PROJECT_SOURCE_DIR}/cmake/batten.pc.in ${PROJECT_BINARY_DIR}/batten.pc @ONLY)
install(FILES ${PROJECT_BINARY_DIR}/batten.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig COMPONENT development)

if(TARGET batten_program)
  install(TARGETS batten_program DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT program)
  # The program knows its own options: it writes the completions and the manual as they are installed.
  if(NOT CMAKE_CROSSCOMPILING)
    install(CODE "
      function(write_from_program file)
        set(place \"\$ENV{DESTDIR}\${CMAKE_INSTALL_PREFIX}/\${file}\")
        execute_process(COMMAND \"$<TARGET_FILE:batten_program>\" \${ARGN} OUTPUT_VARIABLE text COMMAND_ERROR_IS_FATAL ANY)
        file(WRITE \"\${place}\" \"\${text}\")
        if(file MATCHES man1)
          execute_process(COMMAND gzip -9nf \"\${place}\" COMMAND_ERROR_IS_FATAL ANY)
          string(APPEND file .gz)
        endif()
        list(APPEND CMAKE_INSTALL_MANIFEST_FILES \"\${CMAKE_INSTALL_PREFIX}/\${file}\")
        set(CMAKE_INSTALL_MANIFEST_FILES \"\${CMAKE_INSTALL_MANIFEST_FILES}\" PARENT_SCOPE)
      endfunction()
      write_from_program(${CMAKE_INSTALL_DATADIR}/bash-completion/completions/batten completion bash)
      write_from_program(${CMAKE_INSTALL_DATADIR}/zsh/site-functions/_batten completion zsh)
      write_from_program(${CMAKE_INSTALL_DATADIR}/fish/vendor_completions.d/batten.fish completion fish)
      write_from_program(${CMAKE_INSTALL_MANDIR}/man1/batten.1 manual)
      execute_process(COMMAND \"$<TARGET_FILE:batten_program>\" manual OUTPUT_VARIABLE page COMMAND_ERROR_IS_FATAL ANY)
      string(REGEX MATCHALL \"BR batten.-[a-z]+\" commands \"\${page}\")
      foreach(command IN LISTS commands)
        string(REGEX REPLACE \"BR batten.-\" \"\" command \"\${command}\")
        write_from_program(${CMAKE_INSTALL_MANDIR}/man1/batten-\${command}.1 manual \${command})
      endforeach()" COMPONENT program)
  endif()
endif()
# Plug-ins, as users hand them to Blender and FreeCAD. Where there is no Python there is no archive for Blender.
set(plugins ${CMAKE_INSTALL_DATADIR}/batten/plugins)
install(FILES plugins/freecad/batten_surface.FCMacro DESTINATION ${plugins} COMPONENT program)
find_program(BATTEN_PACKING_PYTHON python3)
mark_as_advanced(BATTEN_PACKING_PYTHON)
if(BATTEN_PACKING_PYTHON)
  install(CODE "
    set(archive \"\${CMAKE_INSTALL_PREFIX}/${plugins}/batten_blender.zip\")
    execute_process(COMMAND \"${BATTEN_PACKING_PYTHON}\" \"${PROJECT_SOURCE_DIR}/tools/blender-addon\" \"\$ENV{DESTDIR}\${archive}\"
                    COMMAND_ERROR_IS_FATAL ANY)
    list(APPEND CMAKE_INSTALL_MANIFEST_FILES \"\${archive}\")" COMPONENT program)
endif()
install(FILES README.md DESTINATION ${CMAKE_INSTALL_DOCDIR} COMPONENT program)
install(DIRECTORY docs DESTINATION ${CMAKE_INSTALL_DOCDIR} COMPONENT program)
install(FILES LICENSE CHANGELOG.md DESTINATION ${CMAKE_INSTALL_DOCDIR} COMPONENT notices)
