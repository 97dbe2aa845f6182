# machpoint_add_steppers(target): adds one translation unit for each enabled
# (dimension, basis, method), and core/stepper_list.hpp, which lists them.
# Several small units compile in parallel, and in far less memory than one.

function(machpoint_camel_case out name)
  string(SUBSTRING "${name}" 0 1 head)
  string(SUBSTRING "${name}" 1 -1 tail)
  string(TOUPPER "${head}" head)
  set(${out} "${head}${tail}" PARENT_SCOPE)
endfunction()

# Each item of the list variable must be among the names that follow.
function(machpoint_check_choice variable)
  if(NOT ${variable})
    message(FATAL_ERROR "${variable} is empty; it takes of: ${ARGN}")
  endif()
  foreach(item IN LISTS ${variable})
    if(NOT item IN_LIST ARGN)
      message(FATAL_ERROR "${variable}: no '${item}'; it takes of: ${ARGN}")
    endif()
  endforeach()
endfunction()

function(machpoint_add_steppers target)
  machpoint_check_choice(Machpoint_DIMENSIONS 1 2 3)
  machpoint_check_choice(Machpoint_BASES linear quadratic cubic)
  set(STEPPER_LIST "")
  # Modules exist in every dimension: `list` and `schema` name them all.
  foreach(DIM 1 2 3)
    set(source "${PROJECT_BINARY_DIR}/steppers/modules_${DIM}d.cpp")
    configure_file("${PROJECT_SOURCE_DIR}/cmake/modules.cpp.in" "${source}"
                   @ONLY)
    target_sources(${target} PRIVATE "${source}")
  endforeach()
  foreach(DIM IN LISTS Machpoint_DIMENSIONS)
    foreach(basis IN LISTS Machpoint_BASES)
      foreach(method IN LISTS Machpoint_METHODS)
        machpoint_camel_case(BASIS ${basis})
        machpoint_camel_case(METHOD ${method})
        set(source
            "${PROJECT_BINARY_DIR}/steppers/${method}_${basis}_${DIM}d.cpp")
        configure_file("${PROJECT_SOURCE_DIR}/cmake/stepper.cpp.in"
                       "${source}" @ONLY)
        target_sources(${target} PRIVATE "${source}")
        string(APPEND STEPPER_LIST " \\\n    X( ${DIM}, ${BASIS}, ${METHOD} )")
      endforeach()
    endforeach()
  endforeach()
  configure_file("${PROJECT_SOURCE_DIR}/cmake/stepper_list.hpp.in"
                 "${PROJECT_BINARY_DIR}/include/core/stepper_list.hpp" @ONLY)
endfunction()
