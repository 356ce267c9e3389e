#include "build_info/build_info.h"

#include <fmt/format.h>

#include <systemc>

#include "commit.h"

namespace metabuffer {

std::string build_version() {
    const std::string commit = METABUFFER_COMMIT;
    return commit.empty() ? METABUFFER_VERSION : METABUFFER_VERSION " (" + commit + ")";
}

std::string build_description() {
    return fmt::format("metabuffer {}, SystemC {}.{}.{}, OpenImageIO {}", build_version(),
                       sc_core::sc_version_major, sc_core::sc_version_minor, sc_core::sc_version_patch,
                       METABUFFER_OPENIMAGEIO_VERSION);
}

}  // namespace metabuffer
