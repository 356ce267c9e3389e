#include "build_info/build_info.h"

#include "commit.h"

namespace metabuffer {

std::string build_version() { return METABUFFER_VERSION " (" METABUFFER_COMMIT ")"; }

std::string build_description() {
    return "metabuffer " + build_version() +
           ", SystemC " METABUFFER_SYSTEMC_VERSION ", OpenImageIO " METABUFFER_OPENIMAGEIO_VERSION;
}

}  // namespace metabuffer
