#include "images/image_process.h"

#include <catch2/catch.hpp>
#include <csignal>
#include <fstream>
#include <iterator>
#include <string>

#include "host/child_process.h"
#include "images/image_module.h"
#include "scenario/scenario_template.h"
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

/// The process that this one has started.
pid_t only_child() {
    const std::string pid = std::to_string(getpid());
    return std::stoi(text_of("/proc/" + pid + "/task/" + pid + "/children"));
}

}  // namespace

TEST_CASE("image process: it reads what the codec reads, and this process stays small") {
    const ScenarioFixture fixture;
    const std::filesystem::path exr = fixture.directory() / "image.exr";
    const std::filesystem::path png = fixture.directory() / "colours.png";
    write_black(png, 24, 5);
    ImageProcess images;
    const PixelImage with_z = images.load({exr}, kFormat, kRange);
    const PixelImage far = images.load({png, std::nullopt, 75.0}, kFormat, kRange);
    write_black(fixture.directory() / "depth.exr", 24, 5);
    const PixelImage two_files = images.load({png, fixture.directory() / "depth.exr"}, kFormat, kRange);
    CHECK_FALSE(has_loaded_the_module());

    CHECK((with_z == load_image_here({exr}, kFormat, kRange)));
    CHECK((far == load_image_here({png, std::nullopt, 75.0}, kFormat, kRange)));
    CHECK_FALSE((far == two_files));
    CHECK((two_files == load_image_here({png, fixture.directory() / "depth.exr"}, kFormat, kRange)));
    CHECK(has_loaded_the_module());
}

TEST_CASE(
    "image process: what is wrong with an image is said as the codec says it, and the next one is read") {
    const ScenarioFixture fixture;
    const std::filesystem::path missing = fixture.directory() / "missing.exr";
    ImageProcess images;
    const std::string message = input_error_of([&] { images.load({missing}, kFormat, kRange); });
    CHECK(message.find("missing.exr") != std::string::npos);
    CHECK(images.load({fixture.directory() / "image.exr"}, kFormat, kRange).width_pixels == 16);
    CHECK(message == input_error_of([&] { load_image_here({missing}, kFormat, kRange); }));
}

TEST_CASE("image process: one that is killed costs one image, and another takes its place") {
    const ScenarioFixture fixture;
    const std::filesystem::path exr = fixture.directory() / "image.exr";
    ImageProcess images;
    images.load({exr}, kFormat, kRange);
    kill(only_child(), SIGKILL);
    const std::string message = input_error_of([&] { images.load({exr}, kFormat, kRange); });
    CHECK(message.find("image.exr: the process that reads it ended by a signal: Killed") !=
          std::string::npos);
    CHECK(images.load({exr}, kFormat, kRange).width_pixels == 16);
}

TEST_CASE("image process: a child of this process reads by itself") {
    const ScenarioFixture fixture;
    const std::filesystem::path exr = fixture.directory() / "image.exr";
    ImageProcess images;
    images.load({exr}, kFormat, kRange);
    ChildProcess child([&](const ChildProcess::Sender& sender) {
        const bool reads = images.load({exr}, kFormat, kRange).width_pixels == 16 && has_loaded_the_module();
        sender.send(reads ? "yes" : "no ", 3);
    });
    std::string answer;
    while (!child.ended()) child.receive(answer);
    CHECK(answer == "yes");
    // The two have not mixed up their images.
    CHECK(images.load({exr}, kFormat, kRange).width_pixels == 16);
}

TEST_CASE("image process: a scenario's image that cannot be read is tried once") {
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
    CHECK(reads == 1);
    input_error_of([&] { scenarios.scenario({{"depth_range", "[0, 50]"}}); });
    CHECK(reads == 2);
}

}  // namespace metabuffer::test
