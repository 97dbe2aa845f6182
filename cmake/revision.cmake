# cmake -D SOURCE=... -D UNIT=... -P revision.cmake: writes the revision into a
# unit of its own. configure_file leaves an unchanged one alone, so that nothing is
# recompiled without need.
execute_process(
  COMMAND git rev-parse --show-toplevel
  WORKING_DIRECTORY "${SOURCE}"
  OUTPUT_VARIABLE repository
  OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
execute_process(
  COMMAND git --no-optional-locks describe --always --dirty
  WORKING_DIRECTORY "${SOURCE}"
  OUTPUT_VARIABLE REVISION
  OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET
  RESULT_VARIABLE status)
file(REAL_PATH "${repository}" repository)
file(REAL_PATH "${SOURCE}" source)
# No git, no repository, or one that is not Machpoint's.
if(NOT status EQUAL 0 OR NOT repository STREQUAL source)
  set(REVISION "unknown")
endif()
configure_file("${SOURCE}/core/revision.cpp.in" "${UNIT}" @ONLY)
