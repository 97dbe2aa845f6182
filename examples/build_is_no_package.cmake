# cmake -D BUILD=<build tree> -P: fails where find_package takes it for a package.
find_package(Machpoint CONFIG QUIET NO_DEFAULT_PATH PATHS "${BUILD}")
if(Machpoint_CONSIDERED_CONFIGS)
  message(FATAL_ERROR "${Machpoint_CONSIDERED_CONFIGS} makes a package of the build "
                      "tree: remove it, if a former revision left it there")
endif()
