# The Python module, for installation.cmake: below /usr and other prefixes where Debian's packages are, below /usr/local
# where Debian's Python finds what an administrator has built. The prefix is known only during the installation.
install(CODE "
    set(METABUFFER_PACKAGES lib/python3/dist-packages)
    if(CMAKE_INSTALL_PREFIX STREQUAL \"/usr/local\")
        set(METABUFFER_PACKAGES lib/python${Python_VERSION_MAJOR}.${Python_VERSION_MINOR}/dist-packages)
    endif()" COMPONENT python)
set(python_package "\${METABUFFER_PACKAGES}/metabuffer")
# Both folders are equally deep, so this path is right for either.
file(RELATIVE_PATH to_modules "/lib/python3/dist-packages/metabuffer" "/${METABUFFER_INSTALLED_MODULE_DIRECTORY}")
set_target_properties(metabuffer_python PROPERTIES INSTALL_RPATH "$ORIGIN/${to_modules}")
install(TARGETS metabuffer_python LIBRARY DESTINATION "${python_package}" COMPONENT python)
install(DIRECTORY "${METABUFFER_PYTHON_SOURCES}/" DESTINATION "${python_package}" COMPONENT python
        FILES_MATCHING PATTERN "*.py" PATTERN "*.pyi" PATTERN "py.typed" PATTERN __pycache__ EXCLUDE)
install(FILES python/notebooks/small-buffers.ipynb DESTINATION "${CMAKE_INSTALL_DATADIR}/doc/python3-metabuffer"
        COMPONENT python)
