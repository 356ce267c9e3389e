#include "report/picture_processes.h"

#include <unistd.h>

#include <catch2/catch.hpp>
#include <csignal>
#include <new>
#include <string>

#include "host/errors.h"
#include "host/output_file.h"
#include "host/text_file.h"
#include "support/scratch_directory.h"

using namespace metabuffer;
using test::ScratchDirectory;

namespace {

constexpr std::size_t kMostPixels = 64;

ColourImage picture_of(std::uint32_t colour) {
    ColourImage picture(7, 5);
    for (std::size_t n = 0; n < picture.values.size(); ++n) {
        picture.values[n] = colour + static_cast<std::uint32_t>(n);
    }
    return picture;
}

std::string text_of_picture(const ColourImage& picture) {
    std::string text = std::to_string(picture.width_pixels) + "x" + std::to_string(picture.height_pixels);
    for (const std::uint32_t colour : picture.values) text += " " + std::to_string(colour);
    return text;
}

/// Writes each picture's values and the process that did it.
PictureProcesses::Encode writer_into(const ScratchDirectory& scratch) {
    return [&scratch](const std::string& name, const ColourImage& picture) {
        write_output_file(scratch / name, text_of_picture(picture));
        write_output_file(scratch / (name + ".process"), std::to_string(getpid()));
    };
}

}  // namespace

TEST_CASE("each of many pictures is written whole by a few processes", "[picture]") {
    const ScratchDirectory scratch;
    constexpr std::uint32_t kPictures = 50;
    const std::string own = std::to_string(getpid());
    for (const std::size_t processes : {std::size_t{0}, std::size_t{1}, std::size_t{3}}) {
        INFO(processes << " processes");
        PictureProcesses pictures(processes, kMostPixels, writer_into(scratch));
        for (std::uint32_t n = 0; n < kPictures; ++n) pictures.take(std::to_string(n), picture_of(n * 1000));
        pictures.finish();
        for (std::uint32_t n = 0; n < kPictures; ++n) {
            CHECK(input::text_of_file(scratch / std::to_string(n)) == text_of_picture(picture_of(n * 1000)));
            CHECK((input::text_of_file(scratch / (std::to_string(n) + ".process")) == own) ==
                  (processes == 0));
        }
    }
}

TEST_CASE("a picture larger than the processes' memory is written by the caller", "[picture]") {
    const ScratchDirectory scratch;
    PictureProcesses pictures(2, kMostPixels, writer_into(scratch));
    pictures.take("largest", ColourImage(8, 8, 1));
    pictures.take("larger", ColourImage(13, 5, 1));
    pictures.finish();
    const std::string own = std::to_string(getpid());
    CHECK(input::text_of_file(scratch / "largest.process") != own);
    CHECK(input::text_of_file(scratch / "larger.process") == own);
    CHECK(input::text_of_file(scratch / "larger") == text_of_picture(ColourImage(13, 5, 1)));
}

TEST_CASE("a file that a process cannot write is an error of the caller, with the same text", "[picture]") {
    PictureProcesses pictures(2, kMostPixels, [](const std::string& name, const ColourImage& /*picture*/) {
        if (name == "output") throw OutputError("the disk is full");
        if (name == "input") throw InputError("no module");
    });
    const auto write = [&pictures](const std::string& name) {
        pictures.take(name, picture_of(0));
        pictures.finish();
    };
    CHECK_THROWS_WITH(write("output"), "the disk is full");
    CHECK_THROWS_AS(write("output"), OutputError);
    CHECK_THROWS_WITH(write("input"), "no module");
    CHECK_THROWS_AS(write("input"), InputError);
    CHECK_NOTHROW(write("good"));
}

TEST_CASE("a picture that failed is reported when its process is needed again", "[picture]") {
    PictureProcesses pictures(1, kMostPixels, [](const std::string& name, const ColourImage& /*picture*/) {
        if (name == "bad") throw OutputError("the disk is full");
    });
    pictures.take("bad", picture_of(0));
    CHECK_THROWS_WITH(pictures.take("good", picture_of(0)), "the disk is full");
}

TEST_CASE("the caller writes a picture that a process cannot write or is killed at", "[picture]") {
    const ScratchDirectory scratch;
    const pid_t caller = getpid();
    const PictureProcesses::Encode write = writer_into(scratch);
    PictureProcesses pictures(2, kMostPixels, [&](const std::string& name, const ColourImage& picture) {
        if (getpid() != caller && name == "killed") raise(SIGKILL);
        if (getpid() != caller && name == "no memory") throw std::bad_alloc();
        if (name == "never") throw std::bad_alloc();
        write(name, picture);
    });
    // More of each than there are processes.
    std::uint32_t colour = 0;
    for (const char* name :
         {"no memory", "first", "killed", "second", "killed", "third", "fourth", "fifth"}) {
        INFO(name);
        pictures.take(name, picture_of(++colour));
        pictures.finish();
        CHECK(input::text_of_file(scratch / name) == text_of_picture(picture_of(colour)));
    }
    CHECK(input::text_of_file(scratch / "killed.process") == std::to_string(caller));
    CHECK(input::text_of_file(scratch / "fifth.process") == std::to_string(caller));
    const auto write_never = [&pictures] {
        pictures.take("never", picture_of(0));
        pictures.finish();
    };
    CHECK_THROWS_AS(write_never(), std::bad_alloc);
}
