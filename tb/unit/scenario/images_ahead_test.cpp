#include "images/images_ahead.h"

#include <unistd.h>

#include <catch2/catch.hpp>
#include <csignal>
#include <new>
#include <sstream>
#include <string>
#include <vector>

#include "host/child_process.h"
#include "host/errors.h"
#include "support/child_processes.h"
#include "unit/scenario/scenario_fixture.h"

namespace metabuffer::test {
namespace {

using Images = std::vector<std::shared_ptr<const StoredImage>>;

constexpr int kWidth = 5;
constexpr int kHeight = 3;

/// An image that holds its number and the process that has read it.
std::shared_ptr<const StoredImage> image_that_is(int number) {
    return std::make_shared<const StoredImage>(ImageSize{kWidth, kHeight}, [number] {
        PixelImage image(kWidth, kHeight, Pixel(static_cast<std::uint64_t>(number)));
        image.values.back() = Pixel(static_cast<std::uint64_t>(getpid()));
        return image;
    });
}

Images numbered_images(int count) {
    Images images;
    for (int number = 0; number < count; ++number) images.push_back(image_that_is(number));
    return images;
}

std::uint64_t number_of(const StoredImage& image) { return image.pixels().values.front().word(); }

bool is_read_here(const StoredImage& image) {
    return image.pixels().values.back().word() == static_cast<std::uint64_t>(getpid());
}

}  // namespace

TEST_CASE("images ahead: processes read all images, in whatever order they are needed") {
    constexpr int kImages = 20;
    for (const std::size_t processes : {std::size_t{1}, std::size_t{3}}) {
        INFO(processes << " processes");
        const Images originals = numbered_images(kImages);
        const Images ahead = read_ahead(originals, processes);
        REQUIRE(ahead.size() == kImages);
        CHECK(children_of().size() == processes);
        CHECK(ahead[0]->width_pixels() == kWidth);
        CHECK(ahead[0]->height_pixels() == kHeight);
        for (int n = 0; n < kImages; ++n) {
            const StoredImage& image = *ahead[static_cast<std::size_t>(n)];
            CHECK(number_of(image) == static_cast<std::uint64_t>(n));
            CHECK_FALSE(is_read_here(image));
            CHECK_FALSE(originals[static_cast<std::size_t>(n)]->is_read());
        }
        // Nothing is left to read.
        CHECK(children_of().empty());

        const Images backwards = read_ahead(numbered_images(kImages), processes);
        for (int n = kImages - 1; n >= 0; --n) {
            CHECK(number_of(*backwards[static_cast<std::size_t>(n)]) == static_cast<std::uint64_t>(n));
        }
        CHECK(children_of().empty());
    }
}

TEST_CASE("images ahead: without a process the images are read when they are needed") {
    const Images ahead = read_ahead(numbered_images(2), 0);
    CHECK(children_of().empty());
    CHECK_FALSE(ahead[1]->is_read());
    CHECK(number_of(*ahead[1]) == 1);
    CHECK(is_read_here(*ahead[1]));
}

TEST_CASE("images ahead: an image's fault is thrown to who needs it, and the others are read") {
    Images images = numbered_images(4);
    images[1] = std::make_shared<const StoredImage>(
        ImageSize{kWidth, kHeight}, []() -> PixelImage { throw InputError("one.png: is broken"); });
    const Images ahead = read_ahead(images, 2);
    CHECK(number_of(*ahead[0]) == 0);
    CHECK(input_error_of([&] { ahead[1]->pixels(); }) == "one.png: is broken");
    CHECK(number_of(*ahead[2]) == 2);
    CHECK(number_of(*ahead[3]) == 3);
    CHECK_FALSE(is_read_here(*ahead[3]));
    CHECK(input_error_of([&] { ahead[1]->pixels(); }) == "one.png: is broken");
}

TEST_CASE("images ahead: what a process cannot do for want of memory, this one does") {
    const pid_t owner = getpid();
    Images images = numbered_images(3);
    images[1] = std::make_shared<const StoredImage>(ImageSize{kWidth, kHeight}, [owner] {
        if (getpid() != owner) throw std::bad_alloc();
        return PixelImage(kWidth, kHeight, Pixel(77));
    });
    const Images ahead = read_ahead(images, 1);
    CHECK(number_of(*ahead[0]) == 0);
    CHECK(number_of(*ahead[1]) == 77);
    CHECK(number_of(*ahead[2]) == 2);
    CHECK_FALSE(is_read_here(*ahead[2]));
}

TEST_CASE("images ahead: if the processes are killed, this one reads") {
    const Images ahead = read_ahead(numbered_images(6), 2);
    for (const pid_t child : children_of()) kill(child, SIGKILL);
    for (int n = 0; n < 6; ++n) {
        CHECK(number_of(*ahead[static_cast<std::size_t>(n)]) == static_cast<std::uint64_t>(n));
    }
    CHECK(is_read_here(*ahead[5]));
}

TEST_CASE("images ahead: a child of this process reads by itself") {
    const Images ahead = read_ahead(numbered_images(6), 2);
    ChildProcess child([&](const ChildProcess::Sender& sender) {
        bool reads = true;
        for (std::size_t n = 0; n < 6; ++n) {
            reads = reads && number_of(*ahead[n]) == n && is_read_here(*ahead[n]);
        }
        sender.send(reads ? "yes" : "no ", 3);
    });
    std::string answer;
    while (!child.ended()) child.receive(answer);
    CHECK(answer == "yes");
    for (std::size_t n = 0; n < 6; ++n) CHECK(number_of(*ahead[n]) == n);
    CHECK_FALSE(is_read_here(*ahead[5]));
}

}  // namespace metabuffer::test
