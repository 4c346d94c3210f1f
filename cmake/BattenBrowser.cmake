# The libraries of the browser's engine, in place of find_package(): headers of the distribution one by one (all of
# /usr/include would bring in those of the host's C library), zlib and OpenSubdiv compiled from the distribution's sources,
# which tools/fetch-sources puts below BATTEN_SOURCES. CHOLMOD and Open Cascade stay out: the library does without.
set(BATTEN_SOURCES ${PROJECT_BINARY_DIR}/sources CACHE PATH "Where tools/fetch-sources has put zlib and OpenSubdiv")
foreach(library zlib opensubdiv)
  if(NOT IS_DIRECTORY ${BATTEN_SOURCES}/${library})
    message(FATAL_ERROR "${BATTEN_SOURCES}/${library} is missing. 'tools/build web' fetches it.")
  endif()
endforeach()

set(headers ${PROJECT_BINARY_DIR}/include)
file(MAKE_DIRECTORY ${headers})
foreach(header CGAL boost nlohmann eigen3/Eigen eigen3/unsupported)
  if(NOT EXISTS /usr/include/${header})
    message(FATAL_ERROR "/usr/include/${header} is missing. 'tools/setup build wasm' installs it.")
  endif()
  get_filename_component(name ${header} NAME)
  file(CREATE_LINK /usr/include/${header} ${headers}/${name} SYMBOLIC)
endforeach()

# Exceptions by JavaScript: those of WebAssembly are reported to fail on mobile Safari. Linked and compiled alike.
add_compile_options(-fexceptions)
add_link_options(-fexceptions)

function(batten_browser_library name)
  add_library(${name} INTERFACE IMPORTED GLOBAL)
  target_include_directories(${name} SYSTEM INTERFACE ${headers})
endfunction()
batten_browser_library(Eigen3::Eigen)
batten_browser_library(nlohmann_json::nlohmann_json)
batten_browser_library(CGAL::CGAL)
# Without the second CGAL's predicates are silently wrong: WebAssembly has no directed rounding.
target_compile_definitions(CGAL::CGAL INTERFACE CGAL_DISABLE_GMP=1 CGAL_ALWAYS_ROUND_TO_NEAREST=1)
batten_browser_library(Threads::Threads)

enable_language(C)  # of zlib
file(GLOB zlib_sources ${BATTEN_SOURCES}/zlib/*.c)
add_library(zlib STATIC EXCLUDE_FROM_ALL ${zlib_sources})
target_include_directories(zlib SYSTEM PUBLIC ${BATTEN_SOURCES}/zlib)
target_compile_options(zlib PRIVATE -w)
target_compile_definitions(zlib PRIVATE HAVE_UNISTD_H)
add_library(ZLIB::ZLIB ALIAS zlib)

set(subdiv ${BATTEN_SOURCES}/opensubdiv)
file(GLOB subdiv_sources ${subdiv}/opensubdiv/sdc/*.cpp ${subdiv}/opensubdiv/vtr/*.cpp ${subdiv}/opensubdiv/far/*.cpp)
add_library(opensubdiv STATIC EXCLUDE_FROM_ALL ${subdiv_sources})
target_include_directories(opensubdiv SYSTEM PUBLIC ${subdiv})
target_compile_options(opensubdiv PRIVATE -w)
# In batches, for half the time; four sources have names in common with others.
set_source_files_properties(${subdiv}/opensubdiv/far/catmarkPatchBuilder.cpp ${subdiv}/opensubdiv/far/loopPatchBuilder.cpp
                            ${subdiv}/opensubdiv/vtr/quadRefinement.cpp ${subdiv}/opensubdiv/vtr/triRefinement.cpp
                            PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON)
set_target_properties(opensubdiv PROPERTIES UNITY_BUILD ON UNITY_BUILD_BATCH_SIZE 9)
add_library(OpenSubdiv::CPU ALIAS opensubdiv)
