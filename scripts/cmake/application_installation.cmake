# What applications need, for installation.cmake: the host's library in C, and metabuffer-gl.
set(application_package "${CMAKE_INSTALL_LIBDIR}/cmake/MetabufferApplication")
install(TARGETS metabuffer_host_shared metabuffer_host_static EXPORT MetabufferApplication
        LIBRARY DESTINATION "${CMAKE_INSTALL_LIBDIR}" COMPONENT program NAMELINK_COMPONENT development
        ARCHIVE DESTINATION "${CMAKE_INSTALL_LIBDIR}" COMPONENT development)
install(EXPORT MetabufferApplication FILE MetabufferApplicationConfig.cmake NAMESPACE Metabuffer:: DESTINATION "${application_package}"
        COMPONENT development)
write_basic_package_version_file("${CMAKE_BINARY_DIR}/MetabufferApplicationConfigVersion.cmake" COMPATIBILITY SameMinorVersion)
install(FILES "${CMAKE_BINARY_DIR}/MetabufferApplicationConfigVersion.cmake" DESTINATION "${application_package}" COMPONENT development)
install(FILES model/application/metabuffer_host.h DESTINATION "${CMAKE_INSTALL_INCLUDEDIR}" COMPONENT development)
install(FILES model/application/metabuffer_host.3 DESTINATION "${CMAKE_INSTALL_MANDIR}/man3" COMPONENT development)
configure_file(scripts/cmake/metabuffer_application.pc.in "${CMAKE_BINARY_DIR}/metabuffer_application.pc" @ONLY)
install(FILES "${CMAKE_BINARY_DIR}/metabuffer_application.pc" DESTINATION "${CMAKE_INSTALL_LIBDIR}/pkgconfig"
        COMPONENT development)

install(TARGETS metabuffer_gl LIBRARY DESTINATION "${METABUFFER_INSTALLED_MODULE_DIRECTORY}" COMPONENT program)
install(PROGRAMS "${CMAKE_BINARY_DIR}/model/application/installed/metabuffer-gl" DESTINATION "${CMAKE_INSTALL_BINDIR}"
        COMPONENT program)
