# Whether the Python module is built: METABUFFER_BUILDS_PYTHON.
set(METABUFFER_PYTHON AUTO CACHE STRING "Build the Python module: AUTO (if pybind11 is there), ON or OFF")
set_property(CACHE METABUFFER_PYTHON PROPERTY STRINGS AUTO ON OFF)
set(METABUFFER_BUILDS_PYTHON OFF)
if(METABUFFER_PYTHON STREQUAL "OFF")
    return()
endif()
# An interpreter without the sanitizers cannot load a module with them. Libraries of replaced blocks may not be
# position-independent.
if(METABUFFER_PYTHON STREQUAL "AUTO" AND (METABUFFER_SANITIZE OR METABUFFER_REPLACEMENT))
    return()
endif()
# Debian's Python, since it has Debian's packages of numpy and pandas. Another one may come first on the PATH.
set(Python_EXECUTABLE /usr/bin/python3 CACHE FILEPATH "The Python that the module is for")
find_package(Python COMPONENTS Interpreter Development.Module QUIET)
set(PYBIND11_NOPYTHON OFF)
find_package(pybind11 CONFIG QUIET)
if(Python_FOUND AND pybind11_FOUND)
    set(METABUFFER_BUILDS_PYTHON ON)
    message(STATUS "The Python module is built for ${Python_EXECUTABLE}, ${Python_VERSION}")
elseif(METABUFFER_PYTHON STREQUAL "ON")
    message(FATAL_ERROR "METABUFFER_PYTHON is ON, but pybind11 or the headers of ${Python_EXECUTABLE} are missing; "
                        "apt install pybind11-dev python3-dev")
else()
    message(STATUS "The Python module is not built: pybind11-dev or python3-dev is missing")
endif()
