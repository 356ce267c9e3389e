#include "report/picture_writer.h"

#include <OpenImageIO/imageio.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <string>

#include "host/errors.h"
#include "host/text_file.h"
#include "support/random_seed.h"
#include "support/scratch_directory.h"

using namespace metabuffer;
using test::ScratchDirectory;
namespace fs = std::filesystem;

namespace {

ColourImage random_picture(int width, int height, std::uint64_t seed) {
    test::Random random(seed);
    ColourImage picture(width, height);
    for (std::uint32_t& colour : picture.values)
        colour = static_cast<std::uint32_t>(random.bits() & 0xFF'FFFFU);
    return picture;
}

ColourImage read_picture(const fs::path& file) {
    auto input = OIIO::ImageInput::open(file.string());
    if (input == nullptr) return {};
    const OIIO::ImageSpec& spec = input->spec();
    if (spec.nchannels != 3 || spec.format != OIIO::TypeDesc::UINT8) return {};
    ColourImage picture(spec.width, spec.height);
    std::vector<unsigned char> bytes(picture.values.size() * 3);
    if (!input->read_image(0, 0, 0, 3, OIIO::TypeDesc::UINT8, bytes.data())) return {};
    for (std::size_t n = 0; n < picture.values.size(); ++n) {
        picture.values[n] =
            static_cast<std::uint32_t>(bytes[3 * n] * 0x10000 + bytes[3 * n + 1] * 0x100 + bytes[3 * n + 2]);
    }
    return picture;
}

/// The message of the OutputError that writing throws, "" if it throws none.
template <typename Write>
std::string failure_of(Write write) {
    try {
        write();
    } catch (const OutputError& error) {
        return error.what();
    }
    return "";
}

}  // namespace

TEST_CASE("a PNG holds the picture, pixel for pixel", "[picture]") {
    const std::uint64_t seed = test::random_seed(7);
    INFO("METABUFFER_SEED=" << seed);
    const ScratchDirectory scratch;
    const ColourImage picture = random_picture(37, 23, seed);

    write_png(scratch / "display_1.png", picture);
    CHECK(read_picture(scratch / "display_1.png") == picture);
    CHECK(scratch.names() == std::vector<std::string>{"display_1.png"});

    SECTION("the same picture makes the same bytes, without dates or software names") {
        write_png(scratch / "again.png", picture);
        const std::string bytes = input::text_of_file(scratch / "again.png");
        CHECK(bytes == input::text_of_file(scratch / "display_1.png"));
        for (const char* chunk : {"tIME", "tEXt", "zTXt", "iTXt"}) {
            INFO(chunk);
            CHECK(bytes.find(chunk) == std::string::npos);
        }
    }
    SECTION("an older file is replaced") {
        const ColourImage other = random_picture(5, 6, seed + 1);
        write_png(scratch / "display_1.png", other);
        CHECK(read_picture(scratch / "display_1.png") == other);
        CHECK(scratch.names() == std::vector<std::string>{"display_1.png"});
    }
}

TEST_CASE("a picture that cannot be written is reported in one line and leaves nothing", "[picture]") {
    const ScratchDirectory scratch;

    SECTION("the directory does not exist") {
        const fs::path file = scratch / "missing/display.png";
        CHECK(failure_of([&] { write_png(file, random_picture(64, 64, 3)); }) ==
              "cannot write '" + file.string() + "': No such file or directory");
    }
    SECTION("a picture without pixels") {
        const std::string message = failure_of([&] { write_png(scratch / "empty.png", ColourImage()); });
        INFO(message);
        CHECK(message.find("cannot write '" + (scratch / "empty.png").string() + "': ") == 0);
        CHECK(message.find('\n') == std::string::npos);
    }
    CHECK(scratch.names().empty());
}

TEST_CASE("the collage shows the displays row by row with grey gaps", "[picture]") {
    DisplayConfig config;
    config.columns = 2;
    config.rows = 2;
    config.width_pixels = 2;
    config.height_pixels = 1;
    config.supersample = 4;  // the pictures are already averaged
    std::vector<ColourImage> displays;
    for (std::uint32_t display = 1; display <= 4; ++display) {
        ColourImage picture(2, 1, display);
        picture.at(1, 0) = display + 0x10;
        displays.push_back(picture);
    }

    constexpr std::uint32_t g = 0x808080;
    ColourImage gap_of_one(5, 3);
    gap_of_one.values = {0x01, 0x11, g, 0x02, 0x12,  //
                         g,    g,    g, g,    g,     //
                         0x03, 0x13, g, 0x04, 0x14};
    CHECK(collage(displays, config, 1) == gap_of_one);

    ColourImage no_gap(4, 2);
    no_gap.values = {0x01, 0x11, 0x02, 0x12, 0x03, 0x13, 0x04, 0x14};
    CHECK(collage(displays, config, 0) == no_gap);

    const ColourImage usual = collage(displays, config);
    CHECK(usual.width_pixels == 8);
    CHECK(usual.height_pixels == 6);
    CHECK(usual.at(7, 5) == 0x14);
    CHECK(usual.at(2, 0) == g);
    CHECK(std::count(usual.values.begin(), usual.values.end(), g) == 8 * 6 - 8);
}
