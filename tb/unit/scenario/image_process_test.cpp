#include "images/image_process.h"

#include <catch2/catch.hpp>
#include <csignal>
#include <fstream>
#include <iterator>
#include <string>

#include "host/child_process.h"
#include "images/image_module.h"
#include "scenario/scenario_template.h"
#include "support/scratch_directory.h"
#include "unit/scenario/scenario_fixture.h"

namespace metabuffer::test {
namespace {

constexpr DepthFormat kFormat = DepthFormat::kA8Z16;
constexpr DepthRange kRange{0.0, 100.0};

std::string text_of(const std::string& file) {
    std::ifstream stream(file);
    return {std::istreambuf_iterator<char>(stream), {}};
}

bool has_loaded_the_module() {
    return text_of("/proc/self/maps").find(kImageModuleFile) != std::string::npos;
}

/// A picture with a Z of 75. The test itself must not use OpenImageIO for it: a child of a process that has used
/// OpenEXR outside of the codec waits for threads that it does not have.
ImageFiles write_picture_with_z(const std::filesystem::path& file, int width, int height) {
    const auto bytes = static_cast<std::size_t>(3 * width * height);
    std::ofstream(file) << "P6\n" << width << " " << height << "\n255\n" << std::string(bytes, 'a');
    return {file, std::nullopt, 75.0};
}

/// The process that this one has started.
pid_t only_child() {
    const std::string pid = std::to_string(getpid());
    return std::stoi(text_of("/proc/" + pid + "/task/" + pid + "/children"));
}

}  // namespace

TEST_CASE("image process: it reads what the codec reads, and this process stays small") {
    const ScratchDirectory scratch;
    const ImageFiles wide = write_picture_with_z(scratch / "wide.ppm", 24, 5);
    ImageFiles two_files = write_picture_with_z(scratch / "square.ppm", 9, 9);
    two_files.z.reset();
    two_files.depth = scratch / "depth.pgm";
    std::ofstream(*two_files.depth) << "P5\n9 9\n65535\n" << std::string(std::size_t{9} * 9 * 2, 'b');
    ImageProcess images;
    const PixelImage one = images.load(wide, kFormat, kRange);
    const PixelImage two = images.load(two_files, kFormat, kRange);
    CHECK(one.width_pixels == 24);
    CHECK(two.height_pixels == 9);
    CHECK_FALSE(has_loaded_the_module());

    CHECK((one == load_image_here(wide, kFormat, kRange)));
    CHECK((two == load_image_here(two_files, kFormat, kRange)));
    CHECK(has_loaded_the_module());
}

TEST_CASE(
    "image process: what is wrong with an image is reported as by the codec, and the next one is read") {
    const ScratchDirectory scratch;
    const ImageFiles good = write_picture_with_z(scratch / "good.ppm", 16, 8);
    const std::filesystem::path missing = scratch / "missing.exr";
    ImageProcess images;
    const std::string message = input_error_of([&] { images.load({missing}, kFormat, kRange); });
    CHECK(message.find("missing.exr") != std::string::npos);
    CHECK(images.load(good, kFormat, kRange).width_pixels == 16);
    CHECK_FALSE(has_loaded_the_module());
    CHECK(message == input_error_of([&] { load_image_here({missing}, kFormat, kRange); }));
}

TEST_CASE("image process: if it ends, this process reads the image itself, and all that follow") {
    const ScratchDirectory scratch;
    const ImageFiles good = write_picture_with_z(scratch / "good.ppm", 16, 8);
    ImageProcess images;
    images.load(good, kFormat, kRange);
    kill(only_child(), SIGKILL);
    CHECK_FALSE(has_loaded_the_module());
    CHECK((images.load(good, kFormat, kRange) == load_image_here(good, kFormat, kRange)));
    CHECK(images.load(good, kFormat, kRange).width_pixels == 16);
}

TEST_CASE("image process: a child of this process reads by itself") {
    const ScratchDirectory scratch;
    const ImageFiles good = write_picture_with_z(scratch / "good.ppm", 16, 8);
    ImageProcess images;
    images.load(good, kFormat, kRange);
    ChildProcess child([&](const ChildProcess::Sender& sender) {
        const bool reads = images.load(good, kFormat, kRange).width_pixels == 16 && has_loaded_the_module();
        sender.send(reads ? "yes" : "no ", 3);
    });
    std::string answer;
    while (!child.ended()) child.receive(answer);
    CHECK(answer == "yes");
    // The two have not mixed up their images.
    CHECK(images.load(good, kFormat, kRange).width_pixels == 16);
    CHECK_FALSE(has_loaded_the_module());
}

TEST_CASE(
    "image process: a scenario's image that cannot be read is tried twice, in case that the system was at "
    "fault") {
    const ScenarioFixture fixture;
    int reads = 0;
    const ScenarioTemplate scenarios(
        ScenarioFixture::minimal(), "test.yaml", fixture.directory().path(),
        [&reads](const ImageFiles& files, DepthFormat /*format*/, const DepthRange& /*range*/) -> PixelImage {
            ++reads;
            throw InputError(files.image.string() + ": is broken");
        });
    const std::string first = input_error_of([&] { scenarios.scenario({}); });
    CHECK(first.find("renderers[0].frames[0].image: ") != std::string::npos);
    CHECK(first.find("is broken") != std::string::npos);
    CHECK(input_error_of([&] { scenarios.scenario({{"bus.width_bits", "64"}}); }) == first);
    for (int n = 0; n < 3; ++n) CHECK(input_error_of([&] { scenarios.scenario({}); }) == first);
    CHECK(reads == 2);
    input_error_of([&] { scenarios.scenario({{"depth_range", "[0, 50]"}}); });
    CHECK(reads == 3);
}

}  // namespace metabuffer::test
