# A room of the library: one folder of src/batten, one static library batten_<room> (alias batten::<room>).
#
#   batten_room(NAME mesh PURPOSE "..." USES core linalg SOURCES a.cpp b.cpp [PRIVATE targets...]
#               [LIGHT] [TOGETHER | BATCH n])
#
# TOGETHER, BATCH: the sources are compiled as one, or n at a time, where that saves work (batten_compile_together).
# LIGHT says that the room leaves the numbers to others: it is compiled quickly.
# USES lists the rooms whose headers may be included. The includes of every file in the folder are held
# against it here, at configure time, so that the order of the rooms (README, "The house") cannot decay.
function(batten_room)
  cmake_parse_arguments(ROOM "LIGHT;TOGETHER" "NAME;PURPOSE;BATCH" "USES;SOURCES;PRIVATE;DEFINITIONS" ${ARGN})
  set(target batten_${ROOM_NAME})
  add_library(${target} STATIC ${ROOM_SOURCES})
  add_library(batten::${ROOM_NAME} ALIAS ${target})
  set_target_properties(${target} PROPERTIES EXPORT_NAME ${ROOM_NAME})
  if(NOT EMSCRIPTEN)  # one module, nothing to be moved: code that could be is larger and slower there
    set_target_properties(${target} PROPERTIES POSITION_INDEPENDENT_CODE ON)
    # A section for every function: who links a few of them (-Wl,--gc-sections) leaves out the others of a batch.
    target_compile_options(${target} PRIVATE -ffunction-sections -fdata-sections)
  endif()
  target_include_directories(${target} PUBLIC $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}/src>
                                              $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>)
  target_compile_features(${target} PUBLIC cxx_std_20)
  target_link_libraries(${target} PUBLIC Eigen3::Eigen PRIVATE $<BUILD_INTERFACE:batten_warnings>)
  if(ROOM_LIGHT)
    batten_compile_quickly(${target})
    batten_precompile(${target} GROUP light_rooms HEADERS ${BATTEN_COMMON_HEADERS})
  else()
    batten_precompile(${target} GROUP rooms HEADERS ${BATTEN_COMMON_HEADERS})
  endif()
  if(ROOM_TOGETHER)
    batten_compile_together(${target})
  elseif(ROOM_BATCH)
    batten_compile_together(${target} BATCH ${ROOM_BATCH})
  endif()
  foreach(used IN LISTS ROOM_USES)
    target_link_libraries(${target} PUBLIC batten_${used})
  endforeach()
  if(ROOM_PRIVATE)
    target_link_libraries(${target} PRIVATE ${ROOM_PRIVATE})
  endif()
  if(ROOM_DEFINITIONS)
    target_compile_definitions(${target} PRIVATE ${ROOM_DEFINITIONS})
  endif()

  file(GLOB files CONFIGURE_DEPENDS ${CMAKE_CURRENT_SOURCE_DIR}/*.hpp ${CMAKE_CURRENT_SOURCE_DIR}/*.cpp)
  foreach(file IN LISTS files)
    file(STRINGS ${file} lines REGEX "^#include \"batten/")
    foreach(line IN LISTS lines)
      string(REGEX REPLACE "^#include \"batten/([a-z_]+)/.*" "\\1" included "${line}")
      if(NOT included STREQUAL ROOM_NAME AND NOT included IN_LIST ROOM_USES)
        message(FATAL_ERROR "${file} includes the room '${included}', which '${ROOM_NAME}' may not use. "
                            "A room uses only the rooms that its CMakeLists.txt lists.")
      endif()
    endforeach()
  endforeach()
  batten_check_details(${CMAKE_CURRENT_SOURCE_DIR} ${ROOM_NAME})

  set_property(GLOBAL APPEND PROPERTY BATTEN_ROOMS ${ROOM_NAME})
endfunction()

# Headers *_detail.hpp are private to their room. Configuring fails where a file below a folder includes one of a room
# that is not named here: a room names itself, its tests name it, and programs name none.
#
#   batten_check_details(<folder> [<room>...])
function(batten_check_details folder)
  file(GLOB_RECURSE files CONFIGURE_DEPENDS ${folder}/*.hpp ${folder}/*.cpp)
  foreach(file IN LISTS files)
    file(STRINGS ${file} lines REGEX "^ *# *include +[\"<]batten/[a-z_/]+_detail.hpp")
    foreach(line IN LISTS lines)
      string(REGEX REPLACE ".*batten/([a-z_]+)/.*" "\\1" room "${line}")
      if(NOT room IN_LIST ARGN)
        message(FATAL_ERROR "${file} includes a header that is private to the room '${room}':\n  ${line}\n"
                            "Use a public header of the room; what is missing there belongs into one.")
      endif()
    endforeach()
  endforeach()
endfunction()

# Warnings and sanitizers of our own code; not passed on to those who use the installed package.
add_library(batten_warnings INTERFACE)
if(NOT (BATTEN_BATCHES AND CMAKE_CXX_COMPILER_ID STREQUAL "Clang"))  # for it a name of another source of the batch is in the way
  set(shadow -Wshadow)
endif()
target_compile_options(batten_warnings INTERFACE -Wall -Wextra -Wpedantic ${shadow} -Wnon-virtual-dtor -Werror
                       $<$<CXX_COMPILER_ID:GNU>:-Wno-maybe-uninitialized -Wno-array-bounds -Wno-stringop-overflow -Wno-restrict>)
if(BATTEN_SANITIZE)
  # -O1: the suite runs five times faster than at -O0 and finds the same errors.
  # Left out: null, alignment and vptr take a third of the time to compile, object-size and pointer-overflow another
  # tenth. The address sanitizer stops at null pointers and past the end of anything anyway, and this library casts no
  # pointers to classes down.
  add_compile_options(-fsanitize=address,undefined -fno-sanitize=null,alignment,vptr,object-size,pointer-overflow
                      -fno-sanitize-recover=all -fno-omit-frame-pointer -O1 -g1)
  add_link_options(-fsanitize=address,undefined)
  add_compile_definitions(BATTEN_SANITIZED)  # the compilers' own names for it differ
endif()

# Code around the library, which is compiled more often than it runs and leaves the numbers to the rooms: half the time
# to compile at -O1; under sanitizers -Og takes a third less.
function(batten_compile_quickly target)
  if(BATTEN_SANITIZE)
    target_compile_options(${target} PRIVATE -Og)
  else()
    target_compile_options(${target} PRIVATE $<$<CONFIG:Release>:-O1>)
  endif()
endfunction()
