#include "unit/scenario/scenario_fixture.h"

#include <cstddef>
#include <cstdint>

#include "unit/scenario/picture_files.h"

namespace metabuffer::test {

void write_black(const std::filesystem::path& file, int width, int height) {
    const std::size_t pixels = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
    if (file.extension() == ".exr") {
        write_picture(file, width, height, {{"R", "G", "B", "Z"}, OIIO::TypeDesc::FLOAT},
                      std::vector<float>(4 * pixels));
    } else {
        write_picture(file, width, height, {}, std::vector<std::uint8_t>(3 * pixels));
    }
}

}  // namespace metabuffer::test
