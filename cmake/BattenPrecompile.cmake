# Headers of other libraries that most sources include, compiled once. Saves about a tenth of the time of a room or a test,
# and seven seconds of every command's source.
# A source still includes what it uses; builds without precompiled headers (with a compiler cache) see to that.
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

# Sources of a target that are compiled as one: templates of Eigen, CLI11 and nlohmann that several of them use are compiled
# once (six seconds in every command; a fifth to a third of a room). What stands in their unnamed namespaces has to have
# names of its own. Builds without batches (with a compiler cache) see to it that every source includes what it uses.
#
#   batten_compile_together(<target> [BATCH <n>])
#
# BATCH: n sources at a time, in the order in which the target lists them; else all.
function(batten_compile_together target)
  cmake_parse_arguments(TOGETHER "" "BATCH" "" ${ARGN})
  if(BATTEN_BATCHES)
    if(NOT TOGETHER_BATCH)
      set(TOGETHER_BATCH 0)  # no limit
    endif()
    set_target_properties(${target} PROPERTIES UNITY_BUILD ON UNITY_BUILD_BATCH_SIZE ${TOGETHER_BATCH})
    # Types of an unnamed namespace in a class of a source: there is one such source, wherever it is included.
    target_compile_options(${target} PRIVATE $<$<CXX_COMPILER_ID:GNU>:-Wno-subobject-linkage>)
  endif()
endfunction()
