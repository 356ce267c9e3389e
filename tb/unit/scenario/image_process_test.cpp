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

/// Whether the module is loaded by the test, and not by another test of the same process before it.
class ModuleWatch {
  public:
    bool is_loaded_since() const { return !was_loaded_ && has_loaded_the_module(); }

  private:
    bool was_loaded_ = has_loaded_the_module();
};

/// A picture with a Z of 75. The test itself must not use OpenImageIO for it: a child of a process that has used
/// OpenEXR outside of the codec waits for threads that it does not have.
ImageFiles write_picture_with_z(const std::filesystem::path& file, int width, int height) {
    const auto bytes = static_cast<std::size_t>(3 * width * height);
    std::ofstream(file) << "P6\n" << width << " " << height << "\n255\n" << std::string(bytes, 'a');
    return {file, std::nullopt, 75.0};
}

/// No image has headers that can be read.
struct BrokenImages final : ImageSource {
    mutable int reads = 0;

    ImageSize size(const ImageFiles& files) const override {
        ++reads;
        throw InputError(files.image.string() + ": is broken");
    }
    PixelImage load(const ImageFiles& files, DepthFormat /*format*/,
                    const DepthRange& /*range*/) const override {
        throw InputError(files.image.string() + ": is read though its headers are broken");
    }
};

/// Black images; one has broken pixels, and one another size than its headers say.
struct CountedImages final : ImageSource {
    static constexpr int kBroken = 7;
    static constexpr int kChanged = 8;
    mutable int headers_read = 0;
    mutable int images_read = 0;

    ImageSize size(const ImageFiles& /*files*/) const override {
        ++headers_read;
        return {16, 8};
    }
    PixelImage load(const ImageFiles& files, DepthFormat /*format*/,
                    const DepthRange& /*range*/) const override {
        ++images_read;
        const std::string name = files.image.filename().string();
        if (name == "f" + std::to_string(kBroken) + ".png") throw InputError(name + ": is broken");
        return PixelImage(16, name == "f" + std::to_string(kChanged) + ".png" ? 9 : 8);
    }
};

/// The process that this one has started.
pid_t only_child() {
    const std::string pid = std::to_string(getpid());
    return std::stoi(text_of("/proc/" + pid + "/task/" + pid + "/children"));
}

}  // namespace

TEST_CASE("image process: it reads what the codec reads, and this process stays small") {
    const ScratchDirectory scratch;
    const ModuleWatch module;
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
    CHECK(images.size(wide).width_pixels == 24);
    CHECK(images.size(two_files).height_pixels == 9);
    CHECK_FALSE(module.is_loaded_since());

    CHECK((one == images_here()->load(wide, kFormat, kRange)));
    CHECK((two == images_here()->load(two_files, kFormat, kRange)));
    CHECK(has_loaded_the_module());
}

TEST_CASE(
    "image process: what is wrong with an image is reported as by the codec, and the next one is read") {
    const ScratchDirectory scratch;
    const ModuleWatch module;
    const ImageFiles good = write_picture_with_z(scratch / "good.ppm", 16, 8);
    const std::filesystem::path missing = scratch / "missing.exr";
    ImageProcess images;
    const std::string message = input_error_of([&] { images.load({missing}, kFormat, kRange); });
    CHECK(message.find("missing.exr") != std::string::npos);
    CHECK(images.load(good, kFormat, kRange).width_pixels == 16);
    CHECK_FALSE(module.is_loaded_since());
    CHECK(message == input_error_of([&] { images.size({missing}); }));
    CHECK(images.size(good).height_pixels == 8);
    CHECK_FALSE(module.is_loaded_since());
    CHECK(message == input_error_of([&] { images_here()->load({missing}, kFormat, kRange); }));
}

TEST_CASE("image process: if it ends, this process reads the image itself, and all that follow") {
    const ScratchDirectory scratch;
    const ModuleWatch module;
    const ImageFiles good = write_picture_with_z(scratch / "good.ppm", 16, 8);
    ImageProcess images;
    images.load(good, kFormat, kRange);
    kill(only_child(), SIGKILL);
    CHECK_FALSE(module.is_loaded_since());
    CHECK((images.load(good, kFormat, kRange) == images_here()->load(good, kFormat, kRange)));
    CHECK(images.load(good, kFormat, kRange).width_pixels == 16);
}

TEST_CASE("image process: a child of this process reads by itself") {
    const ScratchDirectory scratch;
    const ModuleWatch module;
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
    CHECK_FALSE(module.is_loaded_since());
}

TEST_CASE(
    "image process: a scenario's image that cannot be read is tried twice, in case that the system was at "
    "fault") {
    const ScenarioFixture fixture;
    const auto images = std::make_shared<const BrokenImages>();
    const int& reads = images->reads;
    const ScenarioTemplate scenarios(ScenarioFixture::minimal(), "test.yaml", fixture.directory().path(),
                                     images);
    const std::string first = input_error_of([&] { scenarios.scenario({}); });
    CHECK(first.find("renderers[0].frames[0].image: ") != std::string::npos);
    CHECK(first.find("is broken") != std::string::npos);
    CHECK(input_error_of([&] { scenarios.scenario({{"bus.width_bits", "64"}}); }) == first);
    for (int n = 0; n < 3; ++n) CHECK(input_error_of([&] { scenarios.scenario({}); }) == first);
    CHECK(reads == 2);
    input_error_of([&] { scenarios.scenario({{"depth_range", "[0, 50]"}}); });
    CHECK(reads == 3);
}

TEST_CASE("image process: a scenario reads headers, and the pixels of the frames that it shows") {
    const ScenarioFixture fixture;
    const auto images = std::make_shared<const CountedImages>();
    const ScenarioTemplate scenarios(
        "displays: {width: 16, height: 8}\n"
        "renderers:\n"
        "  - frames:\n"
        "      - {image: f%d.png, frames: 0-9, z: 1, viewport: {x: 0, y: 0}}\n",
        "test.yaml", fixture.directory().path(), images);
    const Scenario three = scenarios.scenario({{"frames", "3"}});
    CHECK(images->headers_read == 10);
    CHECK(images->images_read == 0);
    CHECK(three.renderers[0].image_width_pixels == 16);
    read_images(three);
    CHECK(images->images_read == 3);
    CHECK_FALSE(three.renderers[0].images[3]->is_read());
    // They are kept for the next scenario that shows them.
    read_images(scenarios.scenario({{"frames", "4"}}));
    CHECK(images->headers_read == 10);
    CHECK(images->images_read == 4);

    const std::string failed =
        input_error_of([&] { scenarios.scenario({}).renderers[0].image_of_pair(CountedImages::kBroken); });
    CHECK(failed.find("test.yaml:4: renderers[0].frames[0].image: ") == 0);
    CHECK(failed.find("f7.png: is broken") != std::string::npos);
    const std::string changed =
        input_error_of([&] { scenarios.scenario({}).renderers[0].image_of_pair(CountedImages::kChanged); });
    CHECK(changed.find("f8.png: has changed its size since the scenario was read") != std::string::npos);
}

}  // namespace metabuffer::test
