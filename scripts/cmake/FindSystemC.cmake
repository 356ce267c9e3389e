# One imported target, SystemC::systemc. Debian's libsystemc-dev brings no CMake package. One of your own is found by
# SystemC_ROOT, CMAKE_PREFIX_PATH or the environment's SYSTEMC_HOME, headers and library in the same place. Headers are
# system headers, so that the compiler does not show their warnings.
find_package(PkgConfig QUIET)
pkg_check_modules(PC_SYSTEMC QUIET systemc)
find_path(SystemC_INCLUDE_DIR systemc.h HINTS ENV SYSTEMC_HOME ${PC_SYSTEMC_INCLUDE_DIRS} PATH_SUFFIXES include)
if(SystemC_INCLUDE_DIR)
    # The library that belongs to these headers, never another one that is installed as well.
    get_filename_component(prefix "${SystemC_INCLUDE_DIR}" DIRECTORY)
    file(GLOB folders "${prefix}/lib-*")  # lib-linux64 and the like, of SystemC's own build
    find_library(SystemC_LIBRARY systemc NO_DEFAULT_PATH
                 PATHS ${folders} "${prefix}/lib64" "${prefix}/lib" "${prefix}/lib/${CMAKE_LIBRARY_ARCHITECTURE}")
    file(GLOB_RECURSE header "${SystemC_INCLUDE_DIR}/sysc/kernel/sc_ver.h")
    if(header)
        file(READ "${header}" header)
        foreach(part IN ITEMS MAJOR MINOR PATCH)
            string(REGEX MATCH "define +SC_VERSION_${part} +([0-9]+)" found "${header}")
            list(APPEND version "${CMAKE_MATCH_1}")
        endforeach()
        list(JOIN version "." SystemC_VERSION)
    endif()
    if(NOT SystemC_LIBRARY)
        set(reason "its headers are in ${SystemC_INCLUDE_DIR}, and there is no libsystemc in ${prefix}")
    endif()
endif()
include(FindPackageHandleStandardArgs)
find_package_handle_standard_args(SystemC REQUIRED_VARS SystemC_LIBRARY SystemC_INCLUDE_DIR
                                  VERSION_VAR SystemC_VERSION REASON_FAILURE_MESSAGE "${reason}")
if(SystemC_FOUND AND NOT TARGET SystemC::systemc)
    find_package(Threads REQUIRED)
    add_library(SystemC::systemc UNKNOWN IMPORTED)
    set_target_properties(SystemC::systemc PROPERTIES
        IMPORTED_LOCATION "${SystemC_LIBRARY}"
        INTERFACE_SYSTEM_INCLUDE_DIRECTORIES "${SystemC_INCLUDE_DIR}"
        INTERFACE_LINK_LIBRARIES Threads::Threads)
    # SystemC links only with code of the language standard that it was built for, unless that code names it.
    file(STRINGS "${SystemC_LIBRARY}" api REGEX "sc_api_version_[0-9_]+cxx[0-9]+L" LIMIT_COUNT 1)
    if(api MATCHES "cxx([0-9]+L)")
        set(SystemC_CPLUSPLUS "${CMAKE_MATCH_1}")
        set_target_properties(SystemC::systemc PROPERTIES
            INTERFACE_COMPILE_DEFINITIONS "SC_CPLUSPLUS=${SystemC_CPLUSPLUS}")
    endif()
endif()
mark_as_advanced(SystemC_INCLUDE_DIR SystemC_LIBRARY)
