# The libraries, for installation.cmake.
set(libraries options host formats datapath images scenario report functional simulation rtl buffer_time tlm schedule
    monitors)
list(TRANSFORM libraries PREPEND metabuffer_ OUTPUT_VARIABLE targets)
foreach(name IN LISTS libraries)
    set_target_properties(metabuffer_${name} PROPERTIES EXPORT_NAME ${name})
endforeach()
# The module that reads images is loaded with the first image, from a folder below the libraries'.
target_link_options(metabuffer_images INTERFACE
    "$<INSTALL_INTERFACE:-Wl,-rpath,$<INSTALL_PREFIX>/${METABUFFER_INSTALLED_MODULE_DIRECTORY}>")
install(TARGETS ${targets} EXPORT MetabufferTargets ARCHIVE DESTINATION "${CMAKE_INSTALL_LIBDIR}" COMPONENT development)
install(EXPORT MetabufferTargets NAMESPACE Metabuffer:: DESTINATION "${package}" COMPONENT development)
foreach(folder host formats datapath images scenario report functional simulation rtl tlm monitors)
    install(DIRECTORY model/${folder} DESTINATION "${CMAKE_INSTALL_INCLUDEDIR}/metabuffer" COMPONENT development
            FILES_MATCHING PATTERN "*.h")
endforeach()
# A block that is replaced changes the machine around it: both levels of a replacement are built from source.
install(DIRECTORY model/rtl model/monitors DESTINATION "${data}/source" COMPONENT development
        FILES_MATCHING PATTERN "*.cpp")

configure_package_config_file(scripts/cmake/MetabufferConfig.cmake.in "${CMAKE_BINARY_DIR}/MetabufferConfig.cmake"
                              INSTALL_DESTINATION "${package}" PATH_VARS data)
write_basic_package_version_file("${CMAKE_BINARY_DIR}/MetabufferConfigVersion.cmake" COMPATIBILITY SameMinorVersion)
install(FILES "${CMAKE_BINARY_DIR}/MetabufferConfig.cmake" "${CMAKE_BINARY_DIR}/MetabufferConfigVersion.cmake"
              scripts/cmake/FindSystemC.cmake scripts/cmake/MetabufferReplacement.cmake
        DESTINATION "${package}" COMPONENT development)

# A linker wants each library before those that it uses.
set(archives ${targets})
list(REMOVE_ITEM archives metabuffer_options)
list(REVERSE archives)
list(TRANSFORM archives PREPEND -l)
list(JOIN archives " " archives)
configure_file(scripts/cmake/metabuffer.pc.in "${CMAKE_BINARY_DIR}/metabuffer.pc" @ONLY)
install(FILES "${CMAKE_BINARY_DIR}/metabuffer.pc" DESTINATION "${CMAKE_INSTALL_LIBDIR}/pkgconfig" COMPONENT development)
