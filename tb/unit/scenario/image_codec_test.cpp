#include "images/image_codec.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <fstream>
#include <iterator>
#include <limits>
#include <string>
#include <vector>

#include "support/address_sanitizer.h"
#include "unit/scenario/picture_files.h"
#include "unit/scenario/scenario_fixture.h"

#ifdef METABUFFER_ADDRESS_SANITIZER
#include <sanitizer/lsan_interface.h>
#endif

namespace metabuffer::test {
namespace {

using OIIO::TypeDesc;

constexpr float kInfinity = std::numeric_limits<float>::infinity();
constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
const std::vector<std::string> kRgba{"R", "G", "B", "A"};
const std::vector<std::string> kRgbaz{"R", "G", "B", "A", "Z"};

bool lacks_z(const std::string& complaint) { return complaint.find("and no Z; use") != std::string::npos; }

/// With Z of the near plane if it has none.
PixelImage load(const std::filesystem::path& file, DepthFormat format = DepthFormat::kA8Z16,
                const ImageReading& reading = {}) {
    ImageFiles files{file};
    try {
        return image_codec().load(files, format, reading);
    } catch (const InputError& error) {
        if (!lacks_z(error.what())) throw;
    }
    files.z = reading.near;
    return image_codec().load(files, format, reading);
}

std::string error_of(const ImageFiles& files, DepthFormat format = DepthFormat::kA8Z16,
                     const ImageReading& reading = {}) {
    return input_error_of([&] { image_codec().load(files, format, reading); });
}

/// What is wrong with it; that it has no Z is allowed.
std::string error_of(const std::filesystem::path& file,
                     const std::optional<std::filesystem::path>& depth = std::nullopt,
                     DepthFormat format = DepthFormat::kA8Z16) {
    ImageFiles files{file, depth};
    const std::string complaint = error_of(files, format);
    if (!lacks_z(complaint)) return complaint;
    files.z = 0.0;
    return error_of(files, format);
}

/// The Z values of an image with `depth` as its depth file, all in one row.
std::vector<std::uint32_t> depths(const ScratchDirectory& directory, const std::string& depth, int width,
                                  DepthFormat format, const ImageReading& reading) {
    write_black(directory / "colour.png", width, 1);
    const PixelImage image =
        image_codec().load({directory / "colour.png", directory / depth}, format, reading);
    std::vector<std::uint32_t> z;
    for (const Pixel& pixel : image.values) z.push_back(pixel.z());
    return z;
}

}  // namespace

TEST_CASE(
    "image: one depth for all of it replaces its Z; without either it is refused, since it would hide "
    "others") {
    const ScratchDirectory directory;
    write_picture<std::uint8_t>(directory / "a.png", 2, 1, {}, {0, 1, 2, 3, 4, 5});
    const ImageFiles none{directory / "a.png"};
    CHECK(error_of(none) == (directory / "a.png").string() +
                                ": has the channels R, G and B and no Z; use depth, a file of Z, z, one "
                                "depth for all of it, or depth_layer, a layer or a channel of the file");
    const auto z_at = [&](double depth, DepthFormat format) {
        ImageFiles files = none;
        files.z = depth;
        const PixelImage image = image_codec().load(files, format, {-10.0, 30.0});
        CHECK(image.at(0, 0).z() == image.at(1, 0).z());
        return image.at(1, 0).z();
    };
    CHECK(z_at(-10.0, DepthFormat::kA8Z16) == 0);
    CHECK(z_at(0.0, DepthFormat::kA8Z16) == 16384);  // 16383.75
    CHECK(z_at(30.0, DepthFormat::kZ24) == 0xFF'FFFF);
    write_picture<float>(directory / "a.exr", 1, 1, {kRgbaz}, {0, 0, 0, 1, 0.75F});
    CHECK(image_codec().load({directory / "a.exr"}, DepthFormat::kA8Z16, {0.0, 1.0}).at(0, 0).z() == 49151);
    ImageFiles files{directory / "a.exr"};
    files.z = 1.0;
    CHECK(image_codec().load(files, DepthFormat::kA8Z16, {0.0, 1.0}).at(0, 0).z() == 65535);
}

TEST_CASE(
    "image: integers are shares of their full scale; floats are clamped, scaled and rounded halves up") {
    const ScratchDirectory directory;
    write_picture<std::uint8_t>(directory / "a.png", 2, 2, {},
                                {0, 1, 2, 3, 4, 5, 127, 128, 129, 253, 254, 255});
    const PixelImage image = load(directory / "a.png");
    CHECK(image.width_pixels == 2);
    CHECK(image.height_pixels == 2);
    CHECK(image.values == std::vector<Pixel>{Pixel(0, 1, 2, 255, 0), Pixel(3, 4, 5, 255, 0),
                                             Pixel(127, 128, 129, 255, 0), Pixel(253, 254, 255, 255, 0)});
    // 255 x 128 / 65535 = 0.498, 255 x 129 / 65535 = 0.502, 255 x 0x12FF / 65535 = 18.92, 127.502.
    const std::vector<std::uint16_t> words{128, 129, 0x0100, 0x12FF, 0x8000, 0xFFFF};
    const std::vector<Pixel> high{Pixel(0, 1, 1, 255, 0), Pixel(19, 128, 255, 255, 0)};
    for (const char* name : {"a.png", "a.tif"}) {
        INFO(name);
        write_picture(directory / name, 2, 1, {{"R", "G", "B"}, TypeDesc::UINT16}, words);
        CHECK(load(directory / name).values == high);
    }
    write_picture<std::uint32_t>(directory / "b.tif", 1, 1, {{"R", "G", "B"}, TypeDesc::UINT32},
                                 {0x00FFFFFF, 0x7F000000, 0xFFFFFFFF});
    CHECK(load(directory / "b.tif").values == std::vector<Pixel>{Pixel(1, 0x7F, 0xFF, 255, 0)});
    const std::vector<float> samples{-1.0F, 0.0F,      0.00196F,   0.00197F, 0.5F, 0.499F,      1.0F, 1.5F,
                                     0.25F, kInfinity, -kInfinity, 0.998F,   0.1F, 1.0F / 3.0F, 0.75F};
    // 0.00196 * 255 = 0.4998, 0.00197 * 255 = 0.50235, 0.5 * 255 = 127.5, 0.499 * 255 = 127.245,
    // 0.25 * 255 = 63.75, 0.998 * 255 = 254.49, 0.1 (a float slightly above) * 255 = 25.5000004, 85, 191.25.
    const std::vector<Pixel> expected{Pixel(0, 0, 0, 255, 0), Pixel(1, 128, 127, 255, 0),
                                      Pixel(255, 255, 64, 255, 0), Pixel(255, 0, 254, 255, 0),
                                      Pixel(26, 85, 191, 255, 0)};
    write_picture(directory / "a.tif", 5, 1, {{"R", "G", "B"}, TypeDesc::FLOAT}, samples);
    CHECK(load(directory / "a.tif").values == expected);
    write_picture(directory / "a.exr", 5, 1, {{"R", "G", "B"}, TypeDesc::FLOAT}, samples);
    CHECK(load(directory / "a.exr").values == expected);
    std::vector<double> twice(samples.begin(), samples.end());
    twice.insert(twice.end(), samples.begin(), samples.end());
    std::vector<Pixel> expected_twice = expected;
    expected_twice.insert(expected_twice.end(), expected.begin(), expected.end());
    write_picture(directory / "d.tif", 5, 2, {{"R", "G", "B"}, TypeDesc::DOUBLE}, twice);
    CHECK(load(directory / "d.tif").values == expected_twice);
}

TEST_CASE("image: halves, also below normal ones, and beside a float Z") {
    const ScratchDirectory directory;
    // Nearest halves: 0.1 -> 0.0999756 (25.49 -> 25), 1e-6 is below the normal halves.
    const std::vector<float> samples{0.5F, 0.1F, 1e-6F, -0.25F, 1.0F, 2.0F, kInfinity, 0.75F, 0.999F};
    write_picture(directory / "a.exr", 3, 1, {{"R", "G", "B"}, TypeDesc::HALF}, samples);
    CHECK(load(directory / "a.exr").values == std::vector<Pixel>{Pixel(128, 25, 0, 255, 0),
                                                                 Pixel(0, 255, 255, 255, 0),
                                                                 Pixel(255, 191, 255, 255, 0)});
    const PictureFormat format{
        kRgbaz,
        TypeDesc::FLOAT,
        {TypeDesc::HALF, TypeDesc::HALF, TypeDesc::HALF, TypeDesc::HALF, TypeDesc::FLOAT}};
    // 0.333333 as a half would be 0.33325: 21839 instead of 21845.
    write_picture<float>(directory / "a.exr", 2, 2, format, {1.0F, 0.5F, 0.25F, 1.0F, 1.0F / 3.0F,  //
                                                             0.0F, 1.0F, 0.5F,  0.5F, 0.0F,         //
                                                             0.0F, 0.0F, 1.0F,  0.0F, 1.0F,         //
                                                             0.1F, 0.1F, 0.1F,  0.1F, 0.5F});
    CHECK(load(directory / "a.exr").values ==
          std::vector<Pixel>{Pixel(255, 128, 64, 255, 21845), Pixel(0, 255, 128, 128, 0),
                             Pixel(0, 0, 255, 0, 65535), Pixel(25, 25, 25, 25, 32768)});
    // z24 leaves the alpha out of what it reads, which lies between B and Z.
    CHECK(load(directory / "a.exr", DepthFormat::kZ24).at(1, 0) == Pixel(0, 255, 128, 255, 0));
}

TEST_CASE("image: every finite half gives what its float gives") {
    const ScratchDirectory directory;
    std::vector<float> samples;
    for (int exponent = -26; exponent <= 1; ++exponent) {
        for (int mantissa = 0; mantissa < 1024; mantissa += 31) {
            const auto value = static_cast<float>(std::ldexp(1024 + mantissa, exponent - 10));
            samples.insert(samples.end(), {value, value, value});
        }
    }
    const int width = static_cast<int>(samples.size() / 3);
    write_picture(directory / "a.exr", width, 1, {{"R", "G", "B"}, TypeDesc::HALF}, samples);
    const PixelImage image = load(directory / "a.exr");
    for (int x = 0; x < width; ++x) {
        // The smallest of these lose bits as halves, far below the first step of a colour.
        const double value = std::min(1.0, double{samples[static_cast<std::size_t>(x) * 3]});
        CHECK(image.at(x, 0).r() == static_cast<int>(std::floor(value * 255 + 0.5)));
    }
}

TEST_CASE("image: alpha is associated on reading, and z24 has none") {
    const ScratchDirectory directory;
    const PictureFormat format{kRgba, TypeDesc::UINT8, {}, true};
    write_picture<std::uint8_t>(directory / "a.png", 3, 1, format,
                                {200, 100, 50, 255, 200, 100, 50, 0, 255, 255, 255, 128});
    const PixelImage image = load(directory / "a.png");
    CHECK(image.values == std::vector<Pixel>{Pixel(200, 100, 50, 255, 0), Pixel(0, 0, 0, 0, 0),
                                             Pixel(128, 128, 128, 128, 0)});
    // An associated file is taken as it is.
    write_picture<std::uint8_t>(directory / "a.tif", 1, 1, {kRgba, TypeDesc::UINT8}, {200, 100, 50, 128});
    CHECK(load(directory / "a.tif").values == std::vector<Pixel>{Pixel(200, 100, 50, 128, 0)});
    write_picture<std::uint8_t>(directory / "a.png", 2, 1, format, {255, 255, 255, 128, 9, 9, 9, 0});
    CHECK(load(directory / "a.png", DepthFormat::kZ24).values ==
          std::vector<Pixel>{Pixel(128, 128, 128, 255, 0), Pixel(0, 0, 0, 255, 0)});
}

TEST_CASE("image: channels go by name, and missing ones are named") {
    const ScratchDirectory directory;
    const PictureFormat format{{"N.x", "Z", "depth.V", "B", "R", "G"}, TypeDesc::FLOAT};
    write_picture<float>(directory / "a.exr", 1, 1, format, {kNan, 0.5F, 0.0F, 0.0F, 1.0F, 0.5F});
    CHECK(load(directory / "a.exr").values == std::vector<Pixel>{Pixel(255, 128, 0, 255, 32768)});
    write_picture<float>(directory / "part.exr", 1, 1, {{"R", "G", "Z"}, TypeDesc::FLOAT}, {0, 0, 0});
    CHECK(error_of(directory / "part.exr") ==
          (directory / "part.exr").string() +
              ": has the channels R, G and Z; use R, G and B, or Y, and A and Z if need be");
}

TEST_CASE("image: tiles read as scanlines do") {
    const ScratchDirectory directory;
    const int width = 70;
    const int height = 41;
    OIIO::ImageSpec spec(width, height, 3, TypeDesc::UINT8);
    spec.tile_width = 32;
    spec.tile_height = 32;
    std::vector<std::uint8_t> samples;
    for (int i = 0; i < width * height; ++i) {
        samples.insert(samples.end(), {static_cast<std::uint8_t>(i), static_cast<std::uint8_t>(i / 7), 9});
    }
    const auto output = OIIO::ImageOutput::create("a.tif");
    REQUIRE(output->open((directory / "a.tif").string(), spec));
    REQUIRE(output->write_image(TypeDesc::UINT8, samples.data()));
    REQUIRE(output->close());
    const PixelImage image = load(directory / "a.tif");
    bool same = true;
    for (int i = 0; i < width * height; ++i) {
        same = same && image.values[static_cast<std::size_t>(i)] ==
                           Pixel(static_cast<std::uint8_t>(i), static_cast<std::uint8_t>(i / 7), 9, 255, 0);
    }
    CHECK(same);
}

TEST_CASE("image: float Z over the depth range") {
    const ScratchDirectory directory;
    const std::vector<float> z{-5.0F, 10.0F, 20.0F, 30.0F, 40.0F, 15.0F, kInfinity, -kInfinity};
    write_picture(directory / "z.tif", 8, 1, {{"Z"}, TypeDesc::FLOAT}, z);
    // (15 - 10) / 20 = 0.25: 16383.75 and 4194303.75; 0.5: 32767.5 and 8388607.5, halves up.
    CHECK(depths(directory, "z.tif", 8, DepthFormat::kA8Z16, {10.0, 30.0}) ==
          std::vector<std::uint32_t>{0, 0, 32768, 65535, 65535, 16384, 65535, 0});
    CHECK(depths(directory, "z.tif", 8, DepthFormat::kZ24, {10.0, 30.0}) ==
          std::vector<std::uint32_t>{0, 0, 8388608, 16777215, 16777215, 4194304, 16777215, 0});
    write_picture(directory / "z.exr", 8, 1, {{"Y"}, TypeDesc::HALF}, z);
    CHECK(depths(directory, "z.exr", 8, DepthFormat::kA8Z16, {10.0, 30.0}) ==
          std::vector<std::uint32_t>{0, 0, 32768, 65535, 65535, 16384, 65535, 0});
    write_picture<double>(directory / "d.tif", 1, 2, {{"Z"}, TypeDesc::DOUBLE}, {0.1, 2.0 / 3.0});
    write_black(directory / "colour.png", 1, 2);
    const PixelImage image =
        image_codec().load({directory / "colour.png", directory / "d.tif"}, DepthFormat::kZ24, {0.0, 1.0});
    CHECK(image.at(0, 0).z() == 1677722);  // 1677721.5 and a little
    CHECK(image.at(0, 1).z() == 11184810);
}

TEST_CASE("image: a Z of the image and a depth file of its own") {
    const ScratchDirectory directory;
    write_picture<float>(directory / "a.exr", 2, 1, {kRgbaz, TypeDesc::FLOAT},
                         {1.0F, 1.0F, 1.0F, 1.0F, kNan, 1.0F, 1.0F, 1.0F, 1.0F, 0.5F});
    write_picture<std::uint16_t>(directory / "z.png", 2, 1, {{"Y"}, TypeDesc::UINT16}, {11, 22});
    // The depth file counts; the image's own Z is not even read.
    const PixelImage image =
        image_codec().load({directory / "a.exr", directory / "z.png"}, DepthFormat::kA8Z16, {});
    CHECK(image.values == std::vector<Pixel>{Pixel(255, 255, 255, 255, 11), Pixel(255, 255, 255, 255, 22)});
    // Several channels: the one named Z.
    write_picture<float>(directory / "z.exr", 2, 1, {{"R", "Z", "N"}, TypeDesc::FLOAT},
                         {kNan, 0.5F, kNan, kNan, 1.0F, kNan});
    CHECK(image_codec()
              .load({directory / "a.exr", directory / "z.exr"}, DepthFormat::kA8Z16, {})
              .at(0, 0)
              .z() == 32768);
    write_picture<std::uint8_t>(directory / "rgb.png", 2, 1, {}, {1, 2, 3, 4, 5, 6});
    CHECK(error_of(directory / "a.exr", directory / "rgb.png") ==
          (directory / "rgb.png").string() +
              ": channel G at x 0, y 0: differs from R; use a file of Z with the same in R, G and B, "
              "depth_bits: rgb24 if they hold 24 bits, or depth_layer");
    write_picture<std::uint8_t>(directory / "small.png", 1, 1, {{"Y"}}, {1});
    CHECK(error_of(directory / "a.exr", directory / "small.png") ==
          (directory / "small.png").string() +
              ": has 1 x 1 pixels; use 2 x 1 pixels, as the image it belongs to");
}

TEST_CASE("image: samples that are no numbers or of other kinds are reported, not read as zeros") {
    const ScratchDirectory directory;
    for (std::size_t channel = 0; channel < 5; ++channel) {
        for (const auto type : {TypeDesc::FLOAT, TypeDesc::HALF}) {
            std::vector<float> samples(30, 0.5F);
            samples[20 + channel] = kNan;
            write_picture(directory / "a.exr", 3, 2, {kRgbaz, type}, samples);
            const std::string or_nothing = kRgbaz[channel] == "Z" ? ", or depth_nothing: [nan]" : "";
            CHECK(error_of(directory / "a.exr") ==
                  (directory / "a.exr").string() + ": channel " + kRgbaz[channel] +
                      " at x 1, y 1: is not a number; use finite values" + or_nothing);
        }
    }
    write_picture<float>(directory / "z.tif", 2, 1, {{"Z"}, TypeDesc::FLOAT}, {0.0F, kNan});
    write_black(directory / "colour.png", 2, 1);
    CHECK(error_of(directory / "colour.png", directory / "z.tif") ==
          (directory / "z.tif").string() +
              ": channel Y at x 1, y 0: is not a number; use finite values, or depth_nothing: [nan]");
    write_picture<std::int16_t>(directory / "a.tif", 1, 1, {{"R", "G", "B"}, TypeDesc::INT16}, {1, 2, 3});
    CHECK(
        error_of(directory / "a.tif") ==
        (directory / "a.tif").string() +
            ": channel R holds int16 values; use unsigned integers of up to 32 bits, half, float or double");
    write_picture<std::int32_t>(directory / "z.tif", 1, 1, {{"Z"}, TypeDesc::INT32}, {1});
    write_black(directory / "colour.png", 1, 1);
    CHECK(error_of(directory / "colour.png", directory / "z.tif") ==
          (directory / "z.tif").string() +
              ": channel Y holds int values; use unsigned integers of up to 32 bits, half, float or double");
    write_picture<double>(directory / "line.tif", 3, 1, {{"Z"}, TypeDesc::DOUBLE}, {0.1, 0.2, 0.3});
    write_black(directory / "colour.png", 3, 1);
    CHECK(error_of(directory / "colour.png", directory / "line.tif") ==
          (directory / "line.tif").string() +
              ": channel Y holds double values in tiles or a single line, which cannot be read from TIFF; "
              "use float, or strips and two lines or more");
    OIIO::ImageSpec spec(3, 2, 3, TypeDesc::DOUBLE);
    spec.tile_width = 16;
    spec.tile_height = 16;
    const std::vector<double> samples(18, 0.5);
    const auto output = OIIO::ImageOutput::create("a.tif");
    REQUIRE(output->open((directory / "tiles.tif").string(), spec));
    REQUIRE(output->write_image(TypeDesc::DOUBLE, samples.data()));
    REQUIRE(output->close());
    CHECK(error_of(directory / "tiles.tif").find(": channel R holds double values in tiles") !=
          std::string::npos);
}

TEST_CASE("image: files that cannot be read, and formats whose readers are not safe") {
    const ScratchDirectory directory;
    const std::string folder = directory.path().string();
    CHECK(error_of(directory / "absent.png") ==
          folder + "/absent.png: cannot be read: No such file or directory");
    CHECK(error_of(directory.path()) == folder + ": cannot be read: Is a directory");
    const auto check_unreadable = [&](const std::string& name) {
        const std::string error = error_of(directory / name);
        INFO(error);
        CHECK(error.rfind(folder + "/" + name + ": is not a readable image: ", 0) == 0);
        CHECK(error.find("; use an intact PNG, OpenEXR, TIFF, PNM, JPEG, WebP, Radiance HDR, SGI or Targa "
                         "(.tga) file") != std::string::npos);
    };
    directory.write("empty.png", "");
    check_unreadable("empty.png");
    directory.write("text.png", "this is no image\n");
    check_unreadable("text.png");
    directory.write("unknown.xyz", "nor is this\n");
    check_unreadable("unknown.xyz");
    std::vector<float> noise(std::size_t{64} * 64 * 3);
    for (std::size_t i = 0; i < noise.size(); ++i) noise[i] = static_cast<float>((i * 7919) % 1000) / 1000.0F;
    for (const std::string name : {"cut.png", "cut.exr", "cut.tif"}) {
        INFO(name);
        write_picture(directory / name, 64, 64, {}, noise);
        std::filesystem::resize_file(directory / name, std::filesystem::file_size(directory / name) / 2);
#ifdef METABUFFER_ADDRESS_SANITIZER
        // libpng leaves OpenImageIO's reader by a long jump, over the destructor of a string.
        const __lsan::ScopedDisabler leak_of_the_library;
#endif
        check_unreadable(name);
    }
    const std::vector<std::uint8_t> samples(std::size_t{4} * 3 * 3, 128);
    for (const std::string suffix : {"ico", "bmp", "gif"}) {
        const std::filesystem::path file = directory / ("a." + suffix);
        write_picture(file, 4, 3, {{"R", "G", "B"}, TypeDesc::UINT8}, samples);
        CHECK(error_of(file) ==
              file.string() +
                  ": is not a readable image: it begins as none of the formats that are read; use an intact "
                  "PNG, OpenEXR, TIFF, PNM, JPEG, WebP, Radiance HDR, SGI or Targa (.tga) file");
    }
}

TEST_CASE("image: formats are recognized by the file's first bytes, not by its name") {
    const ScratchDirectory directory;
    // Grey, since some of the formats only come near to a colour.
    const std::vector<std::uint8_t> samples(std::size_t{16} * 16 * 3, 128);
    for (const std::string suffix : {"png", "exr", "tif", "ppm", "jpg", "webp", "hdr", "sgi", "tga"}) {
        INFO(suffix);
        write_picture(directory / ("written." + suffix), 16, 16, {{"R", "G", "B"}, TypeDesc::UINT8}, samples);
        const std::filesystem::path plain = directory / (suffix == "tga" ? "plain.tga" : "plain");
        std::filesystem::copy_file(directory / ("written." + suffix), plain,
                                   std::filesystem::copy_options::overwrite_existing);
        const PixelImage image = load(plain);
        REQUIRE(image.values.size() == 256);
        for (const Pixel& pixel : image.values) {
            CHECK(std::abs(pixel.r() - 128) <= 1);
            CHECK(pixel.r() == pixel.g());
            CHECK(pixel.r() == pixel.b());
            CHECK(pixel.a() == 255);
            CHECK(pixel.z() == 0);
        }
        std::filesystem::remove(plain);
    }
    std::filesystem::rename(directory / "written.png", directory / "really.tif");
    CHECK(load(directory / "really.tif").width_pixels == 16);
}

TEST_CASE("image: inks are refused") {
    const ScratchDirectory directory;
    const std::string file = (directory / "inks.tif").string();
    OIIO::ImageSpec spec(2, 2, 4, TypeDesc::UINT8);
    spec.attribute("tiff:ColorSpace", "CMYK");
    const std::vector<std::uint8_t> samples(16, 128);
    const auto output = OIIO::ImageOutput::create("a.tif");
    REQUIRE(output->open(file, spec));
    REQUIRE(output->write_image(TypeDesc::UINT8, samples.data()));
    REQUIRE(output->close());
    CHECK(error_of(file) == file + ": holds inks (CMYK); use R, G and B");
}

TEST_CASE("image: sizes up to 8192 a side, a WebP file's before memory is allocated for them") {
    const ScratchDirectory directory;
    write_black(directory / "wide.png", 8192, 1);
    CHECK(load(directory / "wide.png").width_pixels == 8192);
    write_black(directory / "wider.png", 8193, 1);
    CHECK(error_of(directory / "wider.png") ==
          (directory / "wider.png").string() + ": has 8193 x 1 pixels; use 1 to 8192 per side");
    write_black(directory / "higher.png", 1, 8193);
    CHECK(error_of(directory / "higher.png") ==
          (directory / "higher.png").string() + ": has 1 x 8193 pixels; use 1 to 8192 per side");
    using namespace std::string_literals;
    const std::filesystem::path file = directory / "canvas.webp";
    // An extended header that claims an animation, and nothing behind it: OpenImageIO asks for 16 TB before it notices.
    const auto check = [&](const std::string& canvas, const std::string& size) {
        directory.write("canvas.webp", "RIFF\x16\0\0\0WEBPVP8X\x0a\0\0\0\x02\0\0\0"s + canvas);
        CHECK(error_of(file) == file.string() + ": has " + size + " pixels; use 1 to 8192 per side");
    };
    check("\xff\xff\xff\xff\xff\xff"s, "16777216 x 16777216");
    check("\xff\xff\0\xd4\x6a\0"s, "65536 x 27349");
    check("\x03\0\0\0\x20\0"s, "4 x 8193");
    check("\0\x20\0\x03\0\0"s, "8193 x 4");

    const std::vector<std::uint8_t> samples(std::size_t{16} * 16 * 4, 128);
    write_picture(file, 16, 16, {{"R", "G", "B", "A"}, TypeDesc::UINT8}, samples);
    CHECK(load(file).width_pixels == 16);
}

TEST_CASE(
    "image: channels that would take more memory than any image needs are refused before they are read") {
    const ScratchDirectory directory;
    const std::filesystem::path file = directory / "channels.tif";
    // A directory of these tags and nothing behind it; the reader would clear and read strips of 34 GB.
    const auto write_tiff = [&](std::uint16_t channels) {
        std::string bytes("II*\0\x08\0\0\0", 8);
        const auto put = [&bytes](std::uint32_t value, int count) {
            for (int i = 0; i < count; ++i) bytes += static_cast<char>(value >> (8 * i));
        };
        const std::vector<std::pair<std::uint16_t, std::uint32_t>> tags{
            {256, 8192}, {257, 8192},     {258, 8},    {259, 1}, {262, 2},
            {273, 8},    {277, channels}, {278, 8192}, {279, 12}};
        put(static_cast<std::uint32_t>(tags.size()), 2);
        for (const auto& [tag, value] : tags) {
            constexpr std::uint32_t kLong = 4;
            put(tag, 2);
            put(kLong, 2);
            put(1, 4);
            put(value, 4);
        }
        put(0, 4);
        directory.write("channels.tif", bytes);
    };
    write_tiff(511);
    CHECK(error_of(file) ==
          file.string() +
              ": holds 34292 MB in 511 channels; use 2684 MB or less, with no channels but R, G, B, A and Z");
    write_tiff(41);
    CHECK_THAT(error_of(file), Catch::Contains("holds 2751 MB in 41 channels"));
    write_tiff(40);
    ImageFiles files{file};
    files.z = 1.0;
    CHECK(image_codec().size(files).width_pixels == 8192);
}

TEST_CASE("image: an SGI file has one or two bytes a channel") {
    const ScratchDirectory directory;
    const std::filesystem::path file = directory / "channels.sgi";
    const std::vector<std::uint8_t> samples(std::size_t{4} * 3 * 3, 128);
    write_picture(file, 4, 3, {{"R", "G", "B"}, TypeDesc::UINT8}, samples);
    REQUIRE(load(file).width_pixels == 4);
    std::ifstream stream(file, std::ios::binary);
    std::string bytes(std::istreambuf_iterator<char>(stream), {});
    constexpr std::size_t kChannelBytesOffset = 3;
    REQUIRE(bytes[kChannelBytesOffset] == 1);
    // OpenImageIO accepts any number: with 0 it reads beyond its memory, with a negative one it throws.
    for (const int count : {0, 3, 189, 255}) {
        bytes[kChannelBytesOffset] = static_cast<char>(count);
        directory.write("channels.sgi", bytes);
        CHECK_THAT(error_of(file),
                   Catch::Contains(" is not a readable image: it has " + std::to_string(count) +
                                   " bytes a channel, not 1 or 2; use an intact "));
    }
}

TEST_CASE("image: only the first of several subimages is read") {
    const ScratchDirectory directory;
    const auto output = OIIO::ImageOutput::create("a.tif");
    const std::string file = (directory / "a.tif").string();
    const std::vector<OIIO::ImageSpec> specs{OIIO::ImageSpec(1, 1, 3, TypeDesc::UINT8),
                                             OIIO::ImageSpec(2, 2, 3, TypeDesc::UINT8)};
    const std::vector<std::uint8_t> samples{1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12};
    REQUIRE(output->open(file, 2, specs.data()));
    REQUIRE(output->write_image(TypeDesc::UINT8, samples.data()));
    REQUIRE(output->open(file, specs[1], OIIO::ImageOutput::AppendSubimage));
    REQUIRE(output->write_image(TypeDesc::UINT8, samples.data()));
    REQUIRE(output->close());
    CHECK(load(directory / "a.tif").values == std::vector<Pixel>{Pixel(1, 2, 3, 255, 0)});
}

}  // namespace metabuffer::test
