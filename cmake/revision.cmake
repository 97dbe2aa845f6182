# cmake -D SOURCE=... -D UNIT=... -P revision.cmake: writes the revision into a
# unit of its own. configure_file leaves an unchanged one alone, so that nothing is
# recompiled without need.
execute_process(
  COMMAND git --no-optional-locks describe --always --dirty
  WORKING_DIRECTORY "${SOURCE}"
  OUTPUT_VARIABLE REVISION
  OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET
  RESULT_VARIABLE status)
if(NOT status EQUAL 0) # no git, no repository, or somebody else's
  set(REVISION "unknown")
endif()
configure_file("${SOURCE}/core/revision.cpp.in" "${UNIT}" @ONLY)
