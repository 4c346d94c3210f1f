# Installs the build into a folder of its own, builds examples/reconstruct_scan against the installed package as a
# user would, and runs it on the sample scan.
#   cmake -DBUILD=... -DSOURCE=... -P run.cmake
foreach(step_folder prefix example)
  file(REMOVE_RECURSE ${BUILD}/package_test/${step_folder})
endforeach()
function(run)
  execute_process(COMMAND ${ARGN} RESULT_VARIABLE code OUTPUT_VARIABLE out ERROR_VARIABLE out)
  if(NOT code EQUAL 0)
    list(JOIN ARGN " " line)
    message(FATAL_ERROR "${line}\n${out}")
  endif()
endfunction()
set(prefix ${BUILD}/package_test/prefix)
set(example ${BUILD}/package_test/example)
run(${CMAKE_COMMAND} --install ${BUILD} --prefix ${prefix})
run(${CMAKE_COMMAND} -S ${SOURCE}/examples/reconstruct_scan -B ${example} -G Ninja -DCMAKE_BUILD_TYPE=Release
    -DCMAKE_PREFIX_PATH=${prefix})
run(${CMAKE_COMMAND} --build ${example})
run(${example}/reconstruct_scan ${SOURCE}/data/sample.rawnet ${example}/surface.ply)
file(SIZE ${example}/surface.ply size)
if(size LESS 10000)
  message(FATAL_ERROR "the example wrote a surface of ${size} bytes")
endif()
