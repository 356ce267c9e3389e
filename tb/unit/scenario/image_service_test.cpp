#include "images/image_service.h"

#include <unistd.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <csignal>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include "host/child_process.h"
#include "images/image_module.h"
#include "scenario/scenario_template.h"
#include "support/child_processes.h"
#include "support/scratch_directory.h"
#include "unit/scenario/scenario_fixture.h"

namespace metabuffer::test {
namespace {

constexpr DepthFormat kFormat = DepthFormat::kA8Z16;
const ImageReading kRange{0.0, 100.0};

/// What a file of /proc says; nothing, or a part, if its process ends meanwhile.
std::string text_of(const std::string& file) {
    std::ostringstream text;
    text << std::ifstream(file).rdbuf();
    return text.str();
}

bool has_loaded_the_libraries() {
    return text_of("/proc/self/maps").find(kImageModuleFile) != std::string::npos;
}

/// A picture with a Z of 75.
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
    ReadImage load(const ImageFiles& files, DepthFormat /*format*/,
                   const ImageReading& /*reading*/) const override {
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
    ReadImage load(const ImageFiles& files, DepthFormat /*format*/,
                   const ImageReading& /*reading*/) const override {
        ++images_read;
        const std::string name = files.image.filename().string();
        if (name == "f" + std::to_string(kBroken) + ".png") throw InputError(name + ": is broken");
        return PixelImage(16, name == "f" + std::to_string(kChanged) + ".png" ? 9 : 8);
    }
};

/// Kills a process and waits until it has ended, although nobody may have waited for it.
void kill_and_wait(pid_t process) {
    kill(process, SIGKILL);
    const std::string file = "/proc/" + std::to_string(process) + "/stat";
    for (std::string stat = text_of(file); !stat.empty() && stat.find(") Z ") == std::string::npos;
         stat = text_of(file)) {
        usleep(1000);
    }
}

/// A service and a picture that it has read.
struct ServiceFixture {
    ScratchDirectory scratch;
    ImageFiles good = write_picture_with_z(scratch / "good.ppm", 16, 8);
    std::vector<pid_t> others = children_of();
    ImageService images;
    PixelImage picture = images.load(good, kFormat, kRange);

    /// Its process, which this one has started.
    pid_t process() const {
        for (const pid_t child : children_of()) {
            if (std::find(others.begin(), others.end(), child) == others.end()) return child;
        }
        FAIL("this process has not started another");
        return 0;
    }
};

}  // namespace

TEST_CASE("image service: it reads and writes images, and this process never loads the module") {
    const ServiceFixture fixture;
    const ScratchDirectory& scratch = fixture.scratch;
    const ImageService& images = fixture.images;
    ImageFiles two_files = write_picture_with_z(scratch / "square.ppm", 9, 9);
    two_files.z.reset();
    two_files.depth = scratch / "depth.pgm";
    std::ofstream(*two_files.depth) << "P5\n9 9\n65535\n" << std::string(std::size_t{9} * 9 * 2, 'b');
    CHECK((fixture.picture == PixelImage(16, 8, Pixel('a', 'a', 'a', 255, 49151))));
    CHECK((images.load(two_files, kFormat, kRange) == PixelImage(9, 9, Pixel('a', 'a', 'a', 255, 0x6262))));
    CHECK(images.size(fixture.good).width_pixels == 16);
    CHECK(images.size(two_files).height_pixels == 9);

    const ColourImage shown(3, 2, 0x10'2030);
    std::ofstream(scratch / "shown.png") << images.png(shown, "shown.png", "");
    CHECK((images.load({scratch / "shown.png", std::nullopt, 0.0}, kFormat, kRange) ==
           PixelImage(3, 2, Pixel(0x10, 0x20, 0x30, 255, 0))));
    std::ofstream(scratch / "colour.tif") << images.colour_tiff(fixture.picture, "colour.tif");
    std::ofstream(scratch / "depth.tif") << images.depth_tiff(fixture.picture, kFormat, "depth.tif");
    CHECK((images.load({scratch / "colour.tif", scratch / "depth.tif"}, kFormat, kRange) == fixture.picture));
    CHECK_FALSE(has_loaded_the_libraries());
}

TEST_CASE("image service: what is wrong with an image is one line, and the next one is read") {
    const ServiceFixture fixture;
    const std::filesystem::path missing = fixture.scratch / "missing.exr";
    const std::string message = input_error_of([&] { fixture.images.load({missing}, kFormat, kRange); });
    CHECK(message.find("missing.exr") != std::string::npos);
    CHECK((fixture.images.load(fixture.good, kFormat, kRange) == fixture.picture));
    CHECK(message == input_error_of([&] { fixture.images.size({missing}); }));
    CHECK(fixture.images.size(fixture.good).height_pixels == 8);
}

TEST_CASE("image service: an image is asked for again if the process has been killed that reads it") {
    const ServiceFixture fixture;
    // The server alone, which the service has started for this process, and then the service.
    const std::vector<pid_t> servers = children_of(fixture.process());
    REQUIRE(servers.size() == 1);
    kill_and_wait(servers.front());
    CHECK((fixture.images.load(fixture.good, kFormat, kRange) == fixture.picture));
    const pid_t killed = fixture.process();
    kill_and_wait(killed);
    CHECK((fixture.images.load(fixture.good, kFormat, kRange) == fixture.picture));
    const pid_t another = fixture.process();
    CHECK(another != killed);
    // The other service does not hold the ends of this process's connection.
    kill_and_wait(children_of(another).at(0));
    CHECK((fixture.images.load(fixture.good, kFormat, kRange) == fixture.picture));
    CHECK(fixture.process() == another);
}

TEST_CASE("image service: a child of this process has a connection of its own") {
    const ServiceFixture fixture;
    ChildProcess child([&](const ChildProcess::Sender& sender) {
        const bool reads = fixture.images.load(fixture.good, kFormat, kRange) == fixture.picture;
        sender.send(reads && children_of(getpid()).empty() ? "yes" : "no ", 3);
    });
    std::string answer;
    while (!child.ended()) child.receive(answer);
    CHECK(answer == "yes");
    // The two have not mixed up their images.
    CHECK((fixture.images.load(fixture.good, kFormat, kRange) == fixture.picture));
}

TEST_CASE("image service: a child whose parent's service has been killed starts one, and both end") {
    const ServiceFixture fixture;
    ChildProcess child([&, service = fixture.process()](const ChildProcess::Sender& sender) {
        kill_and_wait(service);
        const bool reads = fixture.images.load(fixture.good, kFormat, kRange) == fixture.picture;
        sender.send(reads && children_of(getpid()).size() == 1 ? "yes" : "no ", 3);
    });
    std::string answer;
    while (!child.ended()) child.receive(answer);
    CHECK(answer == "yes");
    CHECK((fixture.images.load(fixture.good, kFormat, kRange) == fixture.picture));
}

TEST_CASE(
    "image service: a scenario's image that cannot be read is tried twice, in case that the system was at "
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

TEST_CASE("image service: a scenario reads headers, and the pixels of the frames that it shows") {
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
