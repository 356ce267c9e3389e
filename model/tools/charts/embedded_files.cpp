#include "tools/charts/embedded_files.h"

#include <cstdint>
#include <cstring>
#include <stdexcept>
#include <string>

/// See embedded_files.S.in.
extern "C" const char metabuffer_embedded_files[];

namespace metabuffer::charts {

std::string_view embedded_file(std::string_view name) {
    const char* at = metabuffer_embedded_files;
    while (*at != 0) {
        const std::string_view its_name = at;
        at += its_name.size() + 1;
        std::uint64_t length = 0;
        std::memcpy(&length, at, sizeof length);
        at += sizeof length;
        if (its_name == name) return {at, length};
        at += length;
    }
    throw std::logic_error("no embedded file " + std::string(name));
}

}  // namespace metabuffer::charts
