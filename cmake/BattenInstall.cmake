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
  # The program knows its own options: it writes the completions and the manual as they are installed.
  if(NOT CMAKE_CROSSCOMPILING)
    install(CODE "
      function(write_from_program file)
        set(place \"\$ENV{DESTDIR}\${CMAKE_INSTALL_PREFIX}/\${file}\")
        execute_process(COMMAND \"$<TARGET_FILE:batten_program>\" \${ARGN} OUTPUT_VARIABLE text COMMAND_ERROR_IS_FATAL ANY)
        file(WRITE \"\${place}\" \"\${text}\")
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
      endforeach()")
  endif()
endif()
install(FILES LICENSE README.md CHANGELOG.md DESTINATION ${CMAKE_INSTALL_DOCDIR})
install(DIRECTORY docs DESTINATION ${CMAKE_INSTALL_DOCDIR})
