#include "unit/scenario/scenario_fixture.h"

#include <cstddef>
#include <cstdint>

#include "unit/scenario/picture_files.h"

namespace metabuffer::test {

void write_black(const std::filesystem::path& file, int width, int height) {
    write_picture(
        file, width, height, {},
        std::vector<std::uint8_t>(static_cast<std::size_t>(width) * static_cast<std::size_t>(height) * 3));
}

}  // namespace metabuffer::test
