# SPDX-License-Identifier: Apache-2.0
#
# Code for wide processors must not be linked in where any processor runs: of the functions that a
# linker may take from one object file for all, those objects define none but of their own lanes.
# cmake -DNM=nm -DOBJECTS=a.o,b.o -P lanes_test.cmake
string(REPLACE "," ";" OBJECTS "${OBJECTS}")
foreach(object IN LISTS OBJECTS)
  execute_process(COMMAND ${NM} -C ${object} OUTPUT_VARIABLE symbols COMMAND_ERROR_IS_FATAL ANY)
  string(REGEX MATCHALL "[^\n]* W [^\n]*" shared "${symbols}")
  if(NOT symbols MATCHES " T metallic_paint::expect_in_lanes_")
    message(FATAL_ERROR "${object} defines no function over lanes")
  endif()
  list(FILTER shared EXCLUDE REGEX "simd_abi::_Vec")
  if(shared)
    message(FATAL_ERROR "${object} defines functions that others may get: ${shared}")
  endif()
endforeach()
