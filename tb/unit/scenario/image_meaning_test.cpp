#include <zlib.h>

#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <fstream>
#include <functional>
#include <iterator>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "images/image_channels.h"
#include "unit/scenario/picture_files.h"
#include "unit/scenario/scenario_fixture.h"

// What image files of users' programs mean: how their picture lies, which channels count, and what samples are.

namespace metabuffer::test::image_meaning_test {
namespace {

using namespace std::string_literals;
using OIIO::TypeDesc;

constexpr float kInfinity = std::numeric_limits<float>::infinity();
constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
const std::vector<std::string> kRgba{"R", "G", "B", "A"};
const std::vector<std::string> kRgbaz{"R", "G", "B", "A", "Z"};

std::string bytes_of(const std::filesystem::path& file) {
    std::ifstream stream(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(stream), {}};
}

std::string number(std::uint32_t value, int bytes, bool highest_first) {
    std::string text;
    for (int n = 0; n < bytes; ++n) {
        const int byte = highest_first ? bytes - 1 - n : n;
        text += static_cast<char>(value >> (8 * byte));
    }
    return text;
}

/// The image, with one depth for all of it.
ReadImage load_colours(const std::filesystem::path& file, const ImageReading& reading = {},
                       const std::optional<std::string>& layer = std::nullopt) {
    ImageFiles files{file};
    files.z = reading.near;
    files.layer = layer;
    return image_codec().load(files, DepthFormat::kA8Z16, reading);
}

std::string error_of(const ImageFiles& files, const ImageReading& reading = {},
                     DepthFormat format = DepthFormat::kA8Z16) {
    return input_error_of([&] { image_codec().load(files, format, reading); });
}

std::vector<std::uint32_t> z_of(const PixelImage& image) {
    std::vector<std::uint32_t> z;
    for (const Pixel& pixel : image.values) z.push_back(pixel.z());
    return z;
}

// ---- orientation ----

/// On which side of the upright picture a file's first row and column are.
struct FirstSides {
    int orientation;
    char row;
    char column;
};
constexpr std::array<FirstSides, 8> kSides{{{1, 't', 'l'},
                                            {2, 't', 'r'},
                                            {3, 'b', 'r'},
                                            {4, 'b', 'l'},
                                            {5, 'l', 't'},
                                            {6, 'r', 't'},
                                            {7, 'r', 'b'},
                                            {8, 'l', 'b'}}};

constexpr int kColumns = 3;  ///< of the file
constexpr int kRows = 2;

/// Red says the row of the file and green the column.
std::vector<std::uint8_t> sample_indices() {
    std::vector<std::uint8_t> samples;
    for (int row = 0; row < kRows; ++row) {
        for (int column = 0; column < kColumns; ++column) {
            samples.insert(samples.end(), {static_cast<std::uint8_t>(64 * (row + 1)),
                                           static_cast<std::uint8_t>(32 * (column + 1)), 128});
        }
    }
    return samples;
}

/// Counts from the side on which the first one is.
int counted_from(char side, int number, int count) {
    return side == 't' || side == 'l' ? number : count - 1 - number;
}

void check_upright(const PixelImage& image, const FirstSides& sides, int tolerance) {
    const bool rows_are_rows = sides.row == 't' || sides.row == 'b';
    REQUIRE(image.width_pixels == (rows_are_rows ? kColumns : kRows));
    REQUIRE(image.height_pixels == (rows_are_rows ? kRows : kColumns));
    for (int row = 0; row < kRows; ++row) {
        for (int column = 0; column < kColumns; ++column) {
            const int along_rows = counted_from(sides.row, row, kRows);
            const int along_columns = counted_from(sides.column, column, kColumns);
            const Pixel pixel =
                rows_are_rows ? image.at(along_columns, along_rows) : image.at(along_rows, along_columns);
            CHECK(std::abs(pixel.r() - 64 * (row + 1)) <= tolerance);
            CHECK(std::abs(pixel.g() - 32 * (column + 1)) <= tolerance);
        }
    }
}

/// Puts a chunk before a PNG file's pixels, behind the signature and the header.
void add_png_chunk(const std::filesystem::path& file, const std::string& type_and_content) {
    constexpr std::size_t kHeaderEnd = 33;
    const std::string png = bytes_of(file);
    const auto sum =
        static_cast<std::uint32_t>(crc32(0, reinterpret_cast<const Bytef*>(type_and_content.data()),
                                         static_cast<uInt>(type_and_content.size())));
    std::ofstream(file, std::ios::binary)
        << png.substr(0, kHeaderEnd)
        << number(static_cast<std::uint32_t>(type_and_content.size()) - 4, 4, true) << type_and_content
        << number(sum, 4, true) << png.substr(kHeaderEnd);
}

/// An EXIF block with nothing but an orientation.
std::string exif_of(int orientation) {
    return "II*\0\x08\0\0\0\x01\0\x12\x01\x03\0\x01\0\0\0"s +
           number(static_cast<std::uint32_t>(orientation), 4, false) + "\0\0\0\0"s;
}

void write_webp(const std::filesystem::path& file, int orientation) {
    write_picture(file, kColumns, kRows, {}, sample_indices());
    const std::string simple = bytes_of(file);
    const std::string exif = exif_of(orientation);
    const std::string chunks = "VP8X\x0a\0\0\0\x08\0\0\0"s + number(kColumns - 1, 3, false) +
                               number(kRows - 1, 3, false) + simple.substr(12) + "EXIF" +
                               number(static_cast<std::uint32_t>(exif.size()), 4, false) + exif;
    std::ofstream(file, std::ios::binary)
        << "RIFF" << number(static_cast<std::uint32_t>(chunks.size() + 4), 4, false) << "WEBP" << chunks;
}

/// Radiance's own words for how pixels follow each other; its y goes up.
void write_radiance(const std::filesystem::path& file, const FirstSides& sides) {
    const auto words = [](char side, int count) {
        const std::string direction = side == 'l' ? "+X" : side == 'r' ? "-X" : side == 't' ? "-Y" : "+Y";
        return direction + " " + std::to_string(count);
    };
    std::ofstream stream(file, std::ios::binary);
    stream << "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n"
           << words(sides.row, kRows) << " " << words(sides.column, kColumns) << "\n";
    const std::vector<std::uint8_t> samples = sample_indices();
    for (std::size_t n = 0; n < samples.size(); ++n) {
        stream << static_cast<char>(samples[n]);
        if (n % 3 == 2) stream << '\x80';
    }
}

/// Its rows may begin at the top or the bottom, at the left or the right.
void write_targa(const std::filesystem::path& file, const FirstSides& sides) {
    const char descriptor =
        static_cast<char>((sides.row == 't' ? 0x20 : 0) | (sides.column == 'r' ? 0x10 : 0));
    std::ofstream stream(file, std::ios::binary);
    stream << "\0\0\x02\0\0\0\0\0\0\0\0\0"s << number(kColumns, 2, false) << number(kRows, 2, false) << '\x18'
           << descriptor;
    const std::vector<std::uint8_t> samples = sample_indices();
    for (std::size_t n = 0; n < samples.size(); n += 3) {
        stream << static_cast<char>(samples[n + 2]) << static_cast<char>(samples[n + 1])
               << static_cast<char>(samples[n]);
    }
}

}  // namespace

TEST_CASE("image: it is upright however its file says that it lies, and so is a file of Z") {
    const ScratchDirectory directory;
    using Write = std::function<void(const std::filesystem::path&, const FirstSides&)>;
    const auto by_library = [](const std::filesystem::path& file, const FirstSides& sides) {
        PictureFormat format;
        format.orientation = sides.orientation;
        write_picture(file, kColumns, kRows, format, sample_indices());
    };
    const auto png = [](const std::filesystem::path& file, const FirstSides& sides) {
        write_picture(file, kColumns, kRows, {}, sample_indices());
        add_png_chunk(file, "eXIf" + exif_of(sides.orientation));
    };
    const auto webp = [](const std::filesystem::path& file, const FirstSides& sides) {
        write_webp(file, sides.orientation);
    };
    struct Row {
        const char* suffix;
        Write write;
        int orientations;  ///< the first so many
        int tolerance;
    };
    constexpr int kLossy = 40;  // for colours that change with every pixel
    const std::vector<Row> rows{{"tif", by_library, 8, 0},      {"png", png, 8, 0},
                                {"jpg", by_library, 8, kLossy}, {"webp", webp, 8, kLossy},
                                {"hdr", write_radiance, 8, 1},  {"tga", write_targa, 4, 0}};
    for (const Row& row : rows) {
        for (const FirstSides& sides : kSides) {
            if (sides.orientation > row.orientations) continue;
            INFO(row.suffix << ", orientation " << sides.orientation);
            const std::filesystem::path file = directory / ("a."s + row.suffix);
            row.write(file, sides);
            check_upright(load_colours(file), sides, row.tolerance);
        }
    }
    write_webp(directory / "a.webp", 9);
    CHECK(load_colours(directory / "a.webp").width_pixels == kColumns);
    write_picture(directory / "a.png", kRows, kColumns, {},
                  std::vector<std::uint8_t>(std::size_t{3} * kRows * kColumns));
    PictureFormat format{{"Y"}, TypeDesc::UINT16};
    format.orientation = 6;  // its first row is on the right
    write_picture<std::uint16_t>(directory / "z.tif", kColumns, kRows, format, {1, 2, 3, 4, 5, 6});
    const ImageFiles files{directory / "a.png", directory / "z.tif"};
    CHECK(image_codec().size(files).width_pixels == kRows);
    CHECK(z_of(image_codec().load(files, DepthFormat::kA8Z16, {})) ==
          std::vector<std::uint32_t>{4, 1, 5, 2, 6, 3});
}

// ---- windows ----

TEST_CASE("image: it is its display window, and what the data window leaves open is empty and far") {
    const ScratchDirectory directory;
    struct Row {
        const char* what;
        int data_x, data_y, width, height;
    };
    // Data windows in a display window of 4 x 3 pixels, whose place in an OpenEXR file may be any.
    const std::vector<Row> rows{{"all of it", 0, 0, 4, 3},
                                {"inside", 1, 1, 2, 1},
                                {"over the right edge", 3, 0, 4, 1},
                                {"over the bottom edge", 0, 2, 2, 5},
                                {"outside", 8, 9, 2, 2},
                                {"over the left edge", -2, 1, 3, 2},
                                {"over the top edge", 1, -2, 1, 4},
                                {"larger", -2, -1, 8, 6}};
    struct Window {
        const char* suffix;
        int x, y;
    };
    for (const Window& window : {Window{"exr", 0, 0}, Window{"exr", 20, -1}, Window{"tif", 0, 0}}) {
        for (const Row& row : rows) {
            INFO(window.suffix << ": " << row.what);
            if (window.suffix == "tif"s && (row.data_x < 0 || row.data_y < 0)) continue;  // it cannot say so
            PictureFormat format{kRgba, TypeDesc::FLOAT};
            format.display_window = OIIO::ROI(window.x, window.x + 4, window.y, window.y + 3);
            format.data_x = window.x + row.data_x;
            format.data_y = window.y + row.data_y;
            std::vector<float> samples;
            for (int y = row.data_y; y < row.data_y + row.height; ++y) {
                for (int x = row.data_x; x < row.data_x + row.width; ++x) {
                    const float column = static_cast<float>(x + 10) / 255.0F;
                    const float line = static_cast<float>(y + 10) / 255.0F;
                    samples.insert(samples.end(), {column, line, 0.2F, 1.0F});
                }
            }
            const std::filesystem::path file = directory / ("a."s + window.suffix);
            write_picture(file, row.width, row.height, format, samples);
            ImageFiles files{file};
            files.z = 0.5;
            const PixelImage image = image_codec().load(files, DepthFormat::kA8Z16, {});
            REQUIRE(image.width_pixels == 4);
            REQUIRE(image.height_pixels == 3);
            for (int y = 0; y < 3; ++y) {
                for (int x = 0; x < 4; ++x) {
                    const bool has_data = x >= row.data_x && x < row.data_x + row.width && y >= row.data_y &&
                                          y < row.data_y + row.height;
                    INFO(x << ", " << y);
                    const Pixel there(static_cast<std::uint8_t>(x + 10), static_cast<std::uint8_t>(y + 10),
                                      51, 255, 32768);
                    CHECK(image.at(x, y) == (has_data ? there : Pixel(0, 0, 0, 0, 65535)));
                }
            }
        }
    }
}

TEST_CASE("image: colours and Z have one display window, each with a data window of its own") {
    const ScratchDirectory directory;
    PictureFormat format{{"R", "G", "B"}, TypeDesc::FLOAT};
    format.display_window = OIIO::ROI(0, 3, 0, 1);
    format.data_x = 1;
    write_picture<float>(directory / "a.exr", 2, 1, format, {1, 1, 1, 1, 1, 1});
    PictureFormat depth{{"Z"}, TypeDesc::FLOAT};
    depth.display_window = format.display_window;
    write_picture<float>(directory / "z.exr", 2, 1, depth, {0.25F, 0.5F});
    const ImageFiles files{directory / "a.exr", directory / "z.exr"};
    CHECK(image_codec().load(files, DepthFormat::kA8Z16, {}).values ==
          std::vector<Pixel>{Pixel(0, 0, 0, 0, 65535), Pixel(255, 255, 255, 255, 32768),
                             Pixel(255, 255, 255, 255, 65535)});
    depth.display_window = OIIO::ROI(1, 4, 0, 1);
    depth.data_x = 1;
    write_picture<float>(directory / "z.exr", 2, 1, depth, {0.25F, 0.5F});
    CHECK(error_of(files) ==
          (directory / "z.exr").string() +
              ": has 3 x 1 pixels from x 1, y 0; use 3 x 1 pixels, as the image it belongs to");
}

// ---- colours ----

TEST_CASE("image: colours that are not multiplied by alpha are, rounded, whatever gamma the file names") {
    const ScratchDirectory directory;
    std::vector<std::uint8_t> samples;
    std::vector<std::uint16_t> words;
    std::vector<Pixel> expected;
    for (int c = 0; c < 256; c += 17) {
        for (const int a : {0, 1, 100, 128, 200, 255}) {
            const auto colour = static_cast<std::uint8_t>(c);
            const auto alpha = static_cast<std::uint8_t>(a);
            samples.insert(samples.end(), {colour, 255, 0, alpha});
            for (const int sample : {c, 255, 0, a}) words.push_back(static_cast<std::uint16_t>(sample * 257));
            const auto product = static_cast<std::uint8_t>(std::lround(c * a / 255.0));
            expected.emplace_back(product, alpha, std::uint8_t{0}, alpha, 0U);
        }
    }
    const int width = static_cast<int>(expected.size());
    const PictureFormat bytes{kRgba, TypeDesc::UINT8, {}, true};
    for (const char* name : {"a.png", "a.tif", "a.tga"}) {
        INFO(name);
        write_picture(directory / name, width, 1, bytes, samples);
        CHECK(load_colours(directory / name).values == expected);
    }
    write_picture(directory / "w.png", width, 1, {kRgba, TypeDesc::UINT16, {}, true}, words);
    CHECK(load_colours(directory / "w.png").values == expected);
    add_png_chunk(directory / "a.png", "gAMA" + number(45455, 4, true));
    CHECK(load_colours(directory / "a.png").values == expected);
}

TEST_CASE("image: grey, with alpha or without, is R, G and B") {
    const ScratchDirectory directory;
    write_picture<std::uint8_t>(directory / "a.png", 2, 1, {{"Y"}}, {7, 200});
    CHECK(load_colours(directory / "a.png").values ==
          std::vector<Pixel>{Pixel(7, 7, 7, 255, 0), Pixel(200, 200, 200, 255, 0)});
    write_picture<std::uint8_t>(directory / "b.png", 2, 1, {{"Y", "A"}, TypeDesc::UINT8, {}, true},
                                {7, 255, 200, 128});
    CHECK(load_colours(directory / "b.png").values ==
          std::vector<Pixel>{Pixel(7, 7, 7, 255, 0), Pixel(100, 100, 100, 128, 0)});
    write_picture<float>(directory / "c.exr", 1, 1, {{"Y"}, TypeDesc::HALF}, {0.5F});
    CHECK(load_colours(directory / "c.exr").values == std::vector<Pixel>{Pixel(128, 128, 128, 255, 0)});
}

TEST_CASE("image: colour_encoding srgb is for floats, not for alpha and not for whole numbers") {
    const ScratchDirectory directory;
    const ImageReading srgb{0.0, 1.0, DepthIntegers::kScaled, DepthBits::kChannel, ColourEncoding::kSrgb};
    // Of IEC 61966-2-1: 0.002 x 12.92 x 255 = 6.6, 0.5 -> 187.5 (187.516), 0.2158605 -> 128.
    write_picture<float>(directory / "a.exr", 2, 1, {kRgba, TypeDesc::FLOAT},
                         {0.002F, 0.5F, 1.0F, 0.5F, -1.0F, 2.0F, 0.2158605F, 1.0F});
    CHECK(load_colours(directory / "a.exr", srgb).values ==
          std::vector<Pixel>{Pixel(7, 188, 255, 128, 0), Pixel(0, 255, 128, 255, 0)});
    write_picture<std::uint8_t>(directory / "a.png", 1, 1, {}, {1, 128, 254});
    CHECK(load_colours(directory / "a.png", srgb).values == std::vector<Pixel>{Pixel(1, 128, 254, 255, 0)});
}

TEST_CASE("image: PNM headers with lines that end in CR and LF are refused before their samples") {
    const ScratchDirectory directory;
    const std::string complaint = ": has a header whose lines end in CR and LF; write it with LF alone";
    const std::string samples(24, 'a');
    for (const std::string& header :
         {"P4\r\n8 1\r\n"s, "P5\r\n2 1\r\n255\r\n"s, "P5\r\n# from a camera\r\n2 1\r\n65535\r\n"s,
          "P6\r\n2 1\r\n255\r\n"s, "Pf\r\n2 1\r\n-1.0\r\n"s, "PF\r\n2 1\r\n-1.0\r\n"s}) {
        INFO(header);
        directory.write("a.pnm", header + samples);
        CHECK(error_of({directory / "a.pnm"}) == (directory / "a.pnm").string() + complaint);
    }
    // One byte ends a header, and the first sample may look like LF; words need no certain byte.
    directory.write("lf.pgm", "P5 2 1 255\r\n\x0b"s);
    CHECK(load_colours(directory / "lf.pgm").values ==
          std::vector<Pixel>{Pixel(10, 10, 10, 255, 0), Pixel(11, 11, 11, 255, 0)});
    directory.write("words.pgm", "P2\r\n2 1\r\n255\r\n7 9\r\n"s);
    CHECK(load_colours(directory / "words.pgm").at(1, 0).r() == 9);
}

// ---- channels ----

namespace {

using image_channels::Part;
using Parts = std::vector<Part>;

/// The names of the channels that are found, part by part if there are several; or the complaint.
template <typename Find>
std::string found(const Parts& parts, Find find) {
    const auto name = [&parts](int part, int channel) -> std::string {
        if (channel == image_channels::kNoChannel) return "-";
        const Part& of = parts[static_cast<std::size_t>(part)];
        const std::string& plain = of.channels[static_cast<std::size_t>(channel)];
        return parts.size() > 1 ? of.name + ":" + plain : plain;
    };
    try {
        return find(name);
    } catch (const InputError& error) {
        return error.what();
    }
}

std::string found_colours(const Parts& parts, const std::optional<std::string>& layer) {
    return found(parts, [&](const auto& name) {
        const image_channels::Colours colours = image_channels::find_colours(parts, layer);
        return name(colours.part, colours.red) + " " + name(colours.part, colours.green) + " " +
               name(colours.part, colours.blue) + " " + name(colours.part, colours.alpha);
    });
}

std::string found_depth(const Parts& parts, const std::optional<std::string>& layer) {
    return found(parts, [&](const auto& name) {
        const image_channels::Depth depth =
            image_channels::find_depth(parts, layer, image_channels::find_colours(parts, std::nullopt));
        return name(depth.part, depth.channel);
    });
}

std::string found_depth_alone(const Parts& parts, const std::optional<std::string>& layer) {
    return found(parts, [&](const auto& name) {
        const image_channels::Depth depth = image_channels::find_depth_alone(parts, layer);
        return name(depth.part, depth.channel) + (depth.colours ? " and colours" : "");
    });
}

struct ChannelRow {
    Parts parts;
    std::optional<std::string> layer;
    std::string found;
};

const Parts kBlender{{"",
                      {"View.Combined.R", "View.Combined.G", "View.Combined.B", "View.Combined.A",
                       "View.Depth.Z", "View.Mist.Z", "View.Normal.X", "View.Normal.Y", "View.Normal.Z"}}};
const Parts kTwoViews{{"",
                       {"A.Combined.R", "A.Combined.G", "A.Combined.B", "A.Depth.Z", "B.Combined.R",
                        "B.Combined.G", "B.Combined.B", "B.Depth.Z"}}};
const Parts kParts{
    {"rgba", {"R", "G", "B", "A"}}, {"depth", {"Z"}}, {"light", {"light.R", "light.G", "light.B"}}};

}  // namespace

TEST_CASE("image channels: colours are those of the layer, the plain ones, or the only ones") {
    const std::vector<ChannelRow> rows{
        {{{"", {"A", "B", "G", "R", "Z"}}}, {}, "R G B A"},
        {{{"", {"R", "G", "B", "light.R", "light.G", "light.B"}}}, {}, "R G B -"},
        {{{"", {"R", "G", "B", "light.R", "light.G", "light.B"}}}, "light", "light.R light.G light.B -"},
        {kBlender, {}, "View.Combined.R View.Combined.G View.Combined.B View.Combined.A"},
        {{{"", {"beauty.r", "beauty.g", "beauty.b", "beauty.a"}}}, {}, "beauty.r beauty.g beauty.b beauty.a"},
        {kTwoViews, {}, "has several layers of colours, A.Combined and B.Combined; use layer, one of them"},
        {kTwoViews, "B.Combined", "B.Combined.R B.Combined.G B.Combined.B -"},
        {kParts, {}, "rgba:R rgba:G rgba:B rgba:A"},
        {kParts, "light", "light:light.R light:light.G light:light.B -"},
        {{{"left", {"R", "G", "B"}}, {"right", {"R", "G", "B"}}},
         {},
         "has several layers of colours, left and right; use layer, one of them"},
        {{{"left", {"R", "G", "B"}}, {"right", {"R", "G", "B"}}}, "right", "right:R right:G right:B -"},
        {{{"", {"Y", "A"}}}, {}, "Y Y Y A"},
        {{{"", {"Y", "RY", "BY"}}},
         {},
         "has the channels Y, RY and BY; use R, G and B, or Y, and A and Z if need be"},
        {kParts, "dark",
         "has the channels rgba.R, rgba.G, rgba.B, rgba.A, depth.Z, light.R, light.G and light.B and no "
         "colours in a layer 'dark'; use layer, a layer with R, G and B"},
    };
    for (const ChannelRow& row : rows) CHECK(found_colours(row.parts, row.layer) == row.found);
}

TEST_CASE("image channels: Z is with the colours, the only one, or the one that is named for depth") {
    const std::vector<ChannelRow> rows{
        {{{"", {"R", "G", "B", "Z", "back.Z"}}}, {}, "Z"},
        {{{"", {"R", "G", "B", "Z", "back.Z"}}}, "back", "back.Z"},
        {{{"", {"R", "G", "B", "depth.Z"}}}, {}, "depth.Z"},
        {{{"", {"R", "G", "B", "depth"}}}, {}, "depth"},
        {{{"", {"R", "G", "B", "main.Depth"}}}, {}, "main.Depth"},
        {{{"", {"R", "G", "B", "distance.V"}}}, "distance", "distance.V"},
        {{{"", {"R", "G", "B", "camera.V", "camera.W"}}}, "camera.W", "camera.W"},
        {kBlender, {}, "View.Depth.Z"},
        {kBlender, "View.Mist", "View.Mist.Z"},
        {kBlender, "View.Normal.Z", "View.Normal.Z"},
        {kParts, {}, "depth:Z"},
        {kParts, "depth", "depth:Z"},
        {{{"", {"R", "G", "B", "left.Z", "right.Z"}}},
         {},
         "has several channels of Z, left.Z and right.Z; use depth_layer, one of them"},
        {{{"", {"R", "G", "B", "N.X", "N.Y", "N.Z"}}},
         {},
         "has the channels R, G, B, N.X, N.Y and N.Z and no Z; use depth, a file of Z, z, one depth for all "
         "of it, or depth_layer, a layer or a channel of the file"},
        {{{"", {"R", "G", "B", "Z"}}},
         "back",
         "has the channels R, G, B and Z and no Z in a layer 'back'; use depth_layer, a layer or a channel "
         "of Z"},
    };
    for (const ChannelRow& row : rows) CHECK(found_depth(row.parts, row.layer) == row.found);
    CHECK(found(kTwoViews, [](const auto& name) {
              const auto colours = image_channels::find_colours(kTwoViews, "B.Combined");
              return name(0, image_channels::find_depth(kTwoViews, std::nullopt, colours).channel);
          }) == "has several channels of Z, A.Depth.Z and B.Depth.Z; use depth_layer, one of them");
}

TEST_CASE("image channels: a file of Z may have one channel, grey, or the same in R, G and B") {
    const std::vector<ChannelRow> rows{
        {{{"", {"Y"}}}, {}, "Y"},
        {{{"", {"anything"}}}, {}, "anything"},
        {{{"", {"Y", "A"}}}, {}, "Y"},
        {{{"", {"R", "Z", "N"}}}, {}, "Z"},
        {{{"", {"R", "G", "B", "A"}}}, {}, "R and colours"},
        {{{"", {"R", "G", "B", "Depth.R", "Depth.G", "Depth.B"}}}, "Depth", "Depth.R and colours"},
        {kBlender, {}, "View.Depth.Z"},
        {{{"", {"U", "V"}}},
         {},
         "has the channels U and V; use one channel, one of several that is called Z, or depth_layer"},
    };
    for (const ChannelRow& row : rows) CHECK(found_depth_alone(row.parts, row.layer) == row.found);
}

TEST_CASE("image: layers and parts of OpenEXR files are read") {
    const ScratchDirectory directory;
    write_picture<float>(directory / "layers.exr", 1, 1,
                         {{"V.Combined.R", "V.Combined.G", "V.Combined.B", "V.Combined.A", "V.Depth.Z",
                           "other.R", "other.G", "other.B"},
                          TypeDesc::FLOAT},
                         {1.0F, 0.2F, 0.4F, 1.0F, 0.25F, 0.0F, 1.0F, 0.0F});
    ImageFiles files{directory / "layers.exr"};
    CHECK_THAT(error_of(files),
               Catch::Contains("several layers of colours, V.Combined and other; use layer"));
    files.layer = "V.Combined";
    CHECK(image_codec().load(files, DepthFormat::kA8Z16, {}).values ==
          std::vector<Pixel>{Pixel(255, 51, 102, 255, 16384)});
    files.layer = "other";
    CHECK(image_codec().load(files, DepthFormat::kA8Z16, {}).values ==
          std::vector<Pixel>{Pixel(0, 255, 0, 255, 16384)});

    std::vector<OIIO::ImageSpec> specs{OIIO::ImageSpec(2, 1, 3, TypeDesc::HALF),
                                       OIIO::ImageSpec(2, 1, 1, TypeDesc::FLOAT)};
    specs[0].attribute("oiio:subimagename", "rgba");
    specs[1].attribute("oiio:subimagename", "depth");
    specs[1].channelnames = {"Z"};
    const auto output = OIIO::ImageOutput::create("a.exr");
    const std::string file = (directory / "parts.exr").string();
    REQUIRE(output->open(file, 2, specs.data()));
    const std::vector<float> colours{0.0F, 0.2F, 0.4F, 0.6F, 0.8F, 1.0F};
    REQUIRE(output->write_image(TypeDesc::FLOAT, colours.data()));
    REQUIRE(output->open(file, specs[1], OIIO::ImageOutput::AppendSubimage));
    const std::vector<float> depths{0.5F, 1.0F};
    REQUIRE(output->write_image(TypeDesc::FLOAT, depths.data()));
    REQUIRE(output->close());
    for (const char* depth_layer : {"", "depth"}) {
        ImageFiles parts{file};
        if (depth_layer != ""s) parts.depth_layer = depth_layer;
        CHECK(image_codec().load(parts, DepthFormat::kA8Z16, {}).values ==
              std::vector<Pixel>{Pixel(0, 51, 102, 255, 32768), Pixel(153, 204, 255, 255, 65535)});
    }
}

// ---- depth ----

namespace {

/// A black picture with a file of Z of one row.
struct DepthFixture {
    ScratchDirectory directory;

    template <typename Sample>
    ImageFiles write(const char* name, const PictureFormat& format,
                     const std::vector<Sample>& samples) const {
        const int width = static_cast<int>(samples.size() / format.channels.size());
        write_black(directory / "colour.png", width, 1);
        write_picture(directory / name, width, 1, format, samples);
        return {directory / "colour.png", directory / name};
    }
};

ImageReading reading_of(double near, double far, std::vector<double> nothing = {},
                        bool nan_is_nothing = false) {
    ImageReading reading{near, far};
    reading.nothing = std::move(nothing);
    reading.nan_is_nothing = nan_is_nothing;
    return reading;
}

}  // namespace

TEST_CASE(
    "image: depths outside of the range are clamped and counted; most of them before near are an error") {
    const DepthFixture fixture;
    struct Row {
        ImageReading reading;
        std::vector<std::uint32_t> z;
        std::int64_t before;
        std::int64_t behind;
    };
    const ImageFiles files =
        fixture.write<float>("z.exr", {{"Z"}, TypeDesc::FLOAT}, {-1.0F, 0.0F, 5.0F, 10.0F, 1e10F, kInfinity});
    const std::vector<Row> rows{
        {reading_of(0, 10), {0, 0, 32768, 65535, 65535, 65535}, 1, 2},
        {reading_of(-1, 10), {0, 5958, 35746, 65535, 65535, 65535}, 0, 2},
        // Larger is nearer: 1e10 and infinity lie before near, and mean nothing here.
        {reading_of(10, 0, {1e10, kInfinity}), {65535, 65535, 32768, 0, 65535, 65535}, 0, 1},
        {reading_of(0, 10, {-1.0}), {65535, 0, 32768, 65535, 65535, 65535}, 0, 2},
    };
    for (const Row& row : rows) {
        const ReadImage image = image_codec().load(files, DepthFormat::kA8Z16, row.reading);
        CHECK(z_of(image) == row.z);
        CHECK(image.clamped.before_near_pixels == row.before);
        CHECK(image.clamped.behind_far_pixels == row.behind);
        CHECK(image.clamped.any() == (row.before + row.behind > 0));
    }
    const auto error = [&](const std::vector<float>& depths, const ImageReading& reading) {
        return error_of(fixture.write("z.exr", {{"Z"}, TypeDesc::FLOAT}, depths), reading);
    };
    CHECK(error({-1, -1, 3, 4, 100, 100}, reading_of(0, 10)).empty());
    CHECK(error({-1, -2, -3, 3, 4, 100}, reading_of(0, 10)) ==
          (fixture.directory / "z.exr").string() +
              ": 3 of its 5 pixels that are not far have a depth before near, 0, such as -1; use a "
              "depth_range with them in it, or depth_nothing if they mean that nothing is there");
    CHECK(error({-1, -1, -1, 3, 4, 100}, reading_of(0, 10, {-1.0})).empty());
    CHECK(error({-1, 100, 100, 100}, reading_of(0, 10)) != "");
    CHECK(error({100, 100}, reading_of(0, 10)).empty());
}

TEST_CASE("image: what is not a number may mean that nothing is there") {
    const DepthFixture fixture;
    const ImageFiles files = fixture.write<float>("z.exr", {{"Z"}, TypeDesc::HALF}, {kNan, 0.5F});
    CHECK_THAT(error_of(files),
               Catch::Contains("at x 0, y 0: is not a number; use finite values, or depth_nothing"));
    CHECK(z_of(image_codec().load(files, DepthFormat::kA8Z16, reading_of(0, 1, {}, true))) ==
          std::vector<std::uint32_t>{65535, 32768});
}

TEST_CASE("image: Z of whole numbers is a share of the file's full scale, or raw") {
    const DepthFixture fixture;
    const ImageFiles bytes =
        fixture.write<std::uint8_t>("z8.png", {{"Y"}, TypeDesc::UINT8}, {0, 7, 128, 255});
    const ImageFiles words =
        fixture.write<std::uint16_t>("z16.png", {{"Y"}, TypeDesc::UINT16}, {0, 300, 32768, 65535});
    const ImageFiles longs = fixture.write<std::uint32_t>("z32.tif", {{"Z"}, TypeDesc::UINT32},
                                                          {0, 65535, 0x8000'0000, 0xFFFF'FFFF});
    const ImageFiles small =
        fixture.write<std::uint32_t>("small.tif", {{"Z"}, TypeDesc::UINT32}, {0, 300, 65535, 16'777'215});
    struct Row {
        const ImageFiles& files;
        DepthFormat format;
        DepthIntegers integers;
        std::vector<std::uint32_t> z;
    };
    constexpr DepthFormat k16 = DepthFormat::kA8Z16;
    constexpr DepthFormat k24 = DepthFormat::kZ24;
    // 7 x 257 = 1799; 7 x 65793 = 460551; 300 x 256.0039 = 76801.17; 32768 x 256.0039 = 8388735.5 (.498)
    const std::vector<Row> rows{
        {bytes, k16, DepthIntegers::kScaled, {0, 1799, 32896, 65535}},
        {bytes, k24, DepthIntegers::kScaled, {0, 460551, 8421504, 16777215}},
        {bytes, k16, DepthIntegers::kRaw, {0, 7, 128, 255}},
        {words, k16, DepthIntegers::kScaled, {0, 300, 32768, 65535}},
        {words, k16, DepthIntegers::kRaw, {0, 300, 32768, 65535}},
        {words, k24, DepthIntegers::kScaled, {0, 76801, 8388736, 16777215}},
        {words, k24, DepthIntegers::kRaw, {0, 300, 32768, 65535}},
        {longs, k16, DepthIntegers::kScaled, {0, 1, 32768, 65535}},
        {longs, k24, DepthIntegers::kScaled, {0, 256, 8388608, 16777215}},
        {small, k24, DepthIntegers::kRaw, {0, 300, 65535, 16777215}},
    };
    for (const Row& row : rows) {
        INFO(row.files.depth->filename() << " to " << layout_of(row.format).name);
        const ImageReading reading{0.0, 100.0, row.integers};
        CHECK(z_of(image_codec().load(row.files, row.format, reading)) == row.z);
        // Larger is nearer.
        std::vector<std::uint32_t> reversed;
        for (const std::uint32_t z : row.z) reversed.push_back(far_z(row.format) - z);
        CHECK(z_of(image_codec().load(row.files, row.format, {100.0, 0.0, row.integers})) == reversed);
    }
    CHECK_THAT(error_of(small, {0.0, 1.0, DepthIntegers::kRaw}),
               Catch::Contains("at x 3, y 0: Z 16777215 is beyond the far plane of the depth format; use 0 "
                               "to 65535, or depth_integers: scaled"));
    CHECK(z_of(image_codec().load(words, k16, reading_of(0, 1, {0.0, 300.0}))) ==
          std::vector<std::uint32_t>{65535, 65535, 32768, 65535});
    // A file with another largest number is read scaled up to 16 bits.
    fixture.directory.write("z.pgm", "P5 4 1 1000\n\0\0\x01\xf4\x03\xe8\0\x01"s);
    const ImageFiles odd{words.image, fixture.directory / "z.pgm"};
    CHECK(z_of(image_codec().load(odd, k16, {})) == std::vector<std::uint32_t>{0, 32767, 65535, 65});
    CHECK_THAT(error_of(odd, {0.0, 1.0, DepthIntegers::kRaw}), Catch::Contains("use depth_integers: scaled"));
}

TEST_CASE("image: a file of Z may hold it in R, G and B, the same in each or 24 bits in all") {
    const DepthFixture fixture;
    const ImageFiles same = fixture.write<float>("rgb.exr", {{"R", "G", "B"}, TypeDesc::FLOAT},
                                                 {0.25F, 0.25F, 0.25F, kNan, kNan, kNan});
    CHECK(z_of(image_codec().load(same, DepthFormat::kA8Z16, reading_of(0, 1, {}, true))) ==
          std::vector<std::uint32_t>{16384, 65535});
    const ImageFiles packed =
        fixture.write<std::uint8_t>("rgb.png", {}, {0, 0, 0, 0x12, 0x34, 0x56, 255, 255, 255});
    CHECK_THAT(error_of(packed), Catch::Contains("channel G at x 1, y 0: differs from R; use a file of Z "
                                                 "with the same in R, G and B, depth_bits: rgb24"));
    ImageReading rgb24;
    rgb24.bits = DepthBits::kRgb24;
    CHECK(z_of(image_codec().load(packed, DepthFormat::kZ24, rgb24)) ==
          std::vector<std::uint32_t>{0, 0x12'3456, 0xFF'FFFF});
    // 0x123456 / 256.0039 = 4660.27
    CHECK(z_of(image_codec().load(packed, DepthFormat::kA8Z16, rgb24)) ==
          std::vector<std::uint32_t>{0, 4660, 65535});
    rgb24.nothing = {0.0};
    CHECK(z_of(image_codec().load(packed, DepthFormat::kZ24, rgb24)).front() == 0xFF'FFFF);
    rgb24.integers = DepthIntegers::kRaw;
    CHECK_THAT(error_of(packed, rgb24), Catch::Contains("at x 1, y 0: Z 1193046 is beyond the far plane"));
    const ImageFiles floats = fixture.write<float>("rgb.exr", {{"R", "G", "B"}, TypeDesc::FLOAT}, {0, 0, 0});
    CHECK_THAT(error_of(floats, rgb24), Catch::Contains("depth_bits: rgb24 needs 8"));
    const ImageFiles grey = fixture.write<std::uint8_t>("y.png", {{"Y"}, TypeDesc::UINT8}, {1, 2});
    CHECK_THAT(error_of(grey, rgb24), Catch::Contains("has no R, G and B that hold Z"));
    // An image's own Z is a channel whatever files of Z are.
    write_picture<float>(fixture.directory / "own.exr", 1, 1, {kRgbaz, TypeDesc::FLOAT}, {1, 1, 1, 1, 0.5F});
    CHECK(image_codec().load({fixture.directory / "own.exr"}, DepthFormat::kA8Z16, rgb24).at(0, 0).z() ==
          32768);
}

}  // namespace metabuffer::test::image_meaning_test
