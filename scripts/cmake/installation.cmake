# What `cmake --install` puts in place, in up to three components: `program` (what people run, with its data),
# `development` (libraries, headers, what CMake and pkg-config need to find them, and the sources of what can be
# replaced) and `python`.
include(CMakePackageConfigHelpers)

# Whatever the umask, all users can read what is installed. CMake's own settings reach only some of the folders, so the
# script of the installation runs in a process of its own that has a usual umask. What is installed by a file of another
# folder would come before that.
install(CODE [[
    if(NOT METABUFFER_HAS_UMASK)
        set(arguments -DMETABUFFER_HAS_UMASK=ON)
        foreach(name CMAKE_INSTALL_PREFIX CMAKE_INSTALL_COMPONENT CMAKE_INSTALL_CONFIG_NAME BUILD_TYPE
                     CMAKE_INSTALL_DO_STRIP CMAKE_INSTALL_LOCAL_ONLY)
            if(DEFINED ${name})
                list(APPEND arguments "-D${name}=${${name}}")
            endif()
        endforeach()
        execute_process(COMMAND sh -c [=[umask 022 && exec "$@"]=] sh "${CMAKE_COMMAND}" ${arguments}
                                -P "${CMAKE_CURRENT_LIST_FILE}"
                        COMMAND_ERROR_IS_FATAL ANY)
        return()
    endif()]] ALL_COMPONENTS)

set(data "${CMAKE_INSTALL_DATADIR}/metabuffer")
set(package "${CMAKE_INSTALL_LIBDIR}/cmake/Metabuffer")

# ---- the program ----
file(RELATIVE_PATH to_modules "/${CMAKE_INSTALL_BINDIR}" "/${METABUFFER_INSTALLED_MODULE_DIRECTORY}")
set_target_properties(metabuffer PROPERTIES INSTALL_RPATH "$ORIGIN/${to_modules}")
set_target_properties(metabuffer_image_module PROPERTIES INSTALL_RPATH "$ORIGIN")
install(TARGETS metabuffer RUNTIME DESTINATION "${CMAKE_INSTALL_BINDIR}" COMPONENT program)
install(TARGETS metabuffer_image_module LIBRARY DESTINATION "${METABUFFER_INSTALLED_MODULE_DIRECTORY}"
        COMPONENT program)
get_property(stand_ins GLOBAL PROPERTY METABUFFER_STAND_INS)
install(FILES ${stand_ins} DESTINATION "${METABUFFER_INSTALLED_MODULE_DIRECTORY}" COMPONENT program)
install(DIRECTORY scenarios waves DESTINATION "${data}" COMPONENT program)
install(FILES README.md CHANGELOG.md LICENSE NOTICE CITATION.cff DESTINATION "${CMAKE_INSTALL_DOCDIR}"
        COMPONENT program)
install(DIRECTORY docs/ DESTINATION "${CMAKE_INSTALL_DOCDIR}/docs" COMPONENT program)
install(FILES scripts/completion/metabuffer.bash RENAME metabuffer
        DESTINATION "${CMAKE_INSTALL_DATADIR}/bash-completion/completions" COMPONENT program)
# The pages come from the program's own help, so they are made when there is a program.
install(CODE "
    set(pages \"\$ENV{DESTDIR}\${CMAKE_INSTALL_PREFIX}/${CMAKE_INSTALL_MANDIR}/man1\")
    execute_process(COMMAND \"${CMAKE_SOURCE_DIR}/scripts/make-manual\" \"$<TARGET_FILE:metabuffer>\" \"\${pages}\"
                    RESULT_VARIABLE status)
    if(NOT status EQUAL 0)
        message(FATAL_ERROR \"scripts/make-manual failed\")
    endif()" COMPONENT program)

file(RELATIVE_PATH to_prefix "/${CMAKE_INSTALL_LIBDIR}/pkgconfig" "/")  # for the files of pkg-config
include(application_installation)

# A build with replaced blocks installs no libraries, since they would not be the model's.
if(NOT METABUFFER_REPLACEMENT)
    include(library_installation)
endif()

set(components program development)
if(METABUFFER_BUILDS_PYTHON)
    include(python_installation)
    list(APPEND components python)
endif()

# ---- Debian packages ----
set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME metabuffer)
set(CPACK_PACKAGE_VENDOR "The Metabuffer model's authors")
set(CPACK_PACKAGE_CONTACT "The Metabuffer model's authors <metabuffer@localhost>")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "executable model of image-compositing hardware")
set(CPACK_RESOURCE_FILE_LICENSE "${CMAKE_SOURCE_DIR}/LICENSE")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_PRE_BUILD_SCRIPTS "${CMAKE_SOURCE_DIR}/scripts/cmake/open_folders.cmake")
set(CPACK_COMPONENTS_GROUPING IGNORE)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_COMPONENTS_ALL ${components})
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SECTION electronics)
set(CPACK_DEBIAN_PROGRAM_PACKAGE_NAME metabuffer)
set(CPACK_DEBIAN_PROGRAM_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PROGRAM_PACKAGE_RECOMMENDS "nodejs, librsvg2-bin, gtkwave")
set(CPACK_DEBIAN_PROGRAM_PACKAGE_SUGGESTS "libsdl2-2.0-0")
set(CPACK_COMPONENT_PROGRAM_DESCRIPTION "The program metabuffer, its scenarios, and how GTKWave shows its waveforms.")
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_NAME libmetabuffer-dev)
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_SECTION libdevel)
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_DEPENDS
    "metabuffer (= ${PROJECT_VERSION}), libsystemc-dev, libfmt-dev, libyaml-cpp-dev, nlohmann-json3-dev, zlib1g-dev, pkg-config")
set(CPACK_COMPONENT_DEVELOPMENT_DESCRIPTION "Libraries of the Metabuffer's levels and monitors, for C++ and SystemC.")
set(CPACK_DEBIAN_PYTHON_PACKAGE_NAME python3-metabuffer)
set(CPACK_DEBIAN_PYTHON_PACKAGE_SECTION python)
set(CPACK_DEBIAN_PYTHON_PACKAGE_SHLIBDEPS ON)
# The program's package has the module that reads images. The extension is for one version of Python.
math(EXPR next_python "${Python_VERSION_MINOR} + 1")
set(CPACK_DEBIAN_PYTHON_PACKAGE_DEPENDS
    "metabuffer (= ${PROJECT_VERSION}), python3 (>= 3.${Python_VERSION_MINOR}), python3 (<< 3.${next_python}), python3-numpy, python3-pandas")
set(CPACK_DEBIAN_PYTHON_PACKAGE_SUGGESTS "python3-notebook, python3-matplotlib")
set(CPACK_COMPONENT_PYTHON_DESCRIPTION "The Metabuffer from Python: runs, sweeps and their results.")
include(CPack)
