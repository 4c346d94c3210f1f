# Headers of other libraries that most sources include, compiled once. Saves about a tenth of the time of a room or a test,
# and seven seconds of every command's source.
# A source still includes what it uses; builds without precompiled headers (a compiler cache, the browser) see to that.
#
#   batten_precompile(<target> GROUP <name> HEADERS <eigen3/Eigen/Core>...)
#
# The first target of a group compiles its headers, the others take them over: they must be compiled alike. (g++ takes
# headers compiled at -O3 into a source at -O1 without a word, and then optimises what is in them as if at -O3.)
function(batten_precompile target)
  cmake_parse_arguments(PRECOMPILE "" "GROUP" "HEADERS" ${ARGN})
  if(NOT BATTEN_PRECOMPILED_HEADERS)
    return()
  endif()
  get_property(owner GLOBAL PROPERTY BATTEN_PRECOMPILED_${PRECOMPILE_GROUP})
  if(owner)
    target_precompile_headers(${target} REUSE_FROM ${owner})
  else()
    target_precompile_headers(${target} PRIVATE ${PRECOMPILE_HEADERS})
    set_property(GLOBAL PROPERTY BATTEN_PRECOMPILED_${PRECOMPILE_GROUP} ${target})
  endif()
endfunction()

set(BATTEN_COMMON_HEADERS <Eigen/Dense> <Eigen/Sparse> <algorithm> <array> <cmath> <functional> <limits> <map> <memory>
                          <numeric> <optional> <string> <string_view> <utility> <vector>)
