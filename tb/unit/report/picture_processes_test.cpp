#include "report/picture_processes.h"

#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <catch2/catch.hpp>
#include <csignal>
#include <map>
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

/// Waits until a child of this process has ended, and leaves it to be reaped.
void wait_for_a_child_to_end() {
    siginfo_t child{};
    REQUIRE(waitid(P_ALL, 0, &child, WEXITED | WNOWAIT) == 0);
}

/// Writes each picture's values and the process that did it.
PictureProcesses::Work writer_into(const ScratchDirectory& scratch) {
    return [&scratch](const std::string& name, const ColourImage& picture) {
        write_output_file(scratch / name, text_of_picture(picture));
        write_output_file(scratch / (name + ".process"), std::to_string(getpid()));
        return false;
    };
}

}  // namespace

TEST_CASE("each of many pictures is written whole by a few processes", "[picture]") {
    const ScratchDirectory scratch;
    constexpr std::uint32_t kPictures = 50;
    const std::string own = std::to_string(getpid());
    for (const std::size_t processes : {std::size_t{0}, std::size_t{1}, std::size_t{3}}) {
        INFO(processes << " processes");
        PictureProcesses pictures({processes, 1, kMostPixels}, writer_into(scratch));
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
    PictureProcesses pictures({2, 1, kMostPixels}, writer_into(scratch));
    pictures.take("largest", ColourImage(8, 8, 1));
    pictures.take("larger", ColourImage(13, 5, 1));
    pictures.finish();
    const std::string own = std::to_string(getpid());
    CHECK(input::text_of_file(scratch / "largest.process") != own);
    CHECK(input::text_of_file(scratch / "larger.process") == own);
    CHECK(input::text_of_file(scratch / "larger") == text_of_picture(ColourImage(13, 5, 1)));
}

TEST_CASE("a file that a process cannot write is an error of the caller, with the same text", "[picture]") {
    PictureProcesses pictures({2, 1, kMostPixels},
                              [](const std::string& name, const ColourImage& /*picture*/) {
                                  if (name == "output") throw OutputError("the disk is full");
                                  if (name == "input") throw InputError("no module");
                                  return false;
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
    PictureProcesses pictures({1, 1, kMostPixels},
                              [](const std::string& name, const ColourImage& /*picture*/) {
                                  if (name == "bad") throw OutputError("the disk is full");
                                  return false;
                              });
    pictures.take("bad", picture_of(0));
    CHECK_THROWS_WITH(pictures.take("good", picture_of(0)), "the disk is full");
}

TEST_CASE("the caller writes a picture that a process cannot write or is killed at", "[picture]") {
    const ScratchDirectory scratch;
    const pid_t caller = getpid();
    const PictureProcesses::Work write = writer_into(scratch);
    PictureProcesses pictures({2, 1, kMostPixels}, [&](const std::string& name, const ColourImage& picture) {
        if (getpid() != caller && name == "killed") raise(SIGKILL);
        if (getpid() != caller && name == "no memory") throw std::bad_alloc();
        if (name == "never") throw std::bad_alloc();
        return write(name, picture);
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

TEST_CASE("pictures that wait in a process are done in the order in which they came", "[picture]") {
    const ScratchDirectory scratch;
    for (const std::size_t each : {std::size_t{1}, std::size_t{2}, std::size_t{5}}) {
        INFO(each << " pictures each");
        // Only the process knows what came before.
        std::string so_far;
        PictureProcesses pictures({1, each, kMostPixels},
                                  [&](const std::string& name, const ColourImage& picture) {
                                      so_far += name + ' ';
                                      write_output_file(scratch / name, so_far + text_of_picture(picture));
                                      return false;
                                  });
        std::string came;
        for (std::uint32_t n = 0; n < 12; ++n) pictures.take(std::to_string(n), picture_of(n * 1000));
        pictures.finish();
        for (std::uint32_t n = 0; n < 12; ++n) {
            came += std::to_string(n) + ' ';
            CHECK(input::text_of_file(scratch / std::to_string(n)) ==
                  came + text_of_picture(picture_of(n * 1000)));
        }
    }
}

TEST_CASE("the pictures that the work gives back reach the caller, each with its name", "[picture]") {
    const pid_t caller = getpid();
    for (const std::size_t processes : {std::size_t{0}, std::size_t{1}, std::size_t{2}}) {
        INFO(processes << " processes");
        std::map<std::string, std::string> back;
        PictureProcesses pictures(
            {processes, 3, kMostPixels},
            [caller](const std::string& name, const ColourImage& /*picture*/) {
                // A process that ends leaves what it holds to the caller.
                if (getpid() != caller && name == "10") raise(SIGKILL);
                return std::stoi(name) % 3 != 0;
            },
            [&](const std::string& name, const ColourImage& picture) {
                CHECK(getpid() == caller);
                CHECK(back.emplace(name, text_of_picture(picture)).second);
            });
        for (std::uint32_t n = 0; n < 20; ++n) pictures.take(std::to_string(n), picture_of(n * 1000));
        pictures.take("100", ColourImage(13, 5, 1));  // larger than the processes' memory
        pictures.finish();
        CHECK(back.size() == 14);
        for (const auto& [name, text] : back) {
            const auto n = static_cast<std::uint32_t>(std::stoi(name));
            INFO(name);
            CHECK(n % 3 != 0);
            CHECK(text == text_of_picture(n == 100 ? ColourImage(13, 5, 1) : picture_of(n * 1000)));
        }
    }
}

TEST_CASE("what a process had done before it was killed counts, and the caller does the rest", "[picture]") {
    const pid_t caller = getpid();
    std::array<int, 2> all_are_handed_over{};
    REQUIRE(pipe(all_are_handed_over.data()) == 0);
    std::string back;
    std::string here;
    PictureProcesses pictures(
        {1, 4, kMostPixels},
        [&](const std::string& name, const ColourImage& /*picture*/) {
            char byte = 0;
            if (getpid() == caller) {
                here += name;
            } else if (name == "a") {
                return read(all_are_handed_over[0], &byte, 1) == 1;
            } else if (name == "c") {
                raise(SIGKILL);
            }
            return true;
        },
        [&](const std::string& name, const ColourImage& picture) {
            back += name + text_of_picture(picture) + "\n";
        });
    std::string handed_over;
    for (const char* name : {"a", "b", "c", "d"}) {
        const ColourImage picture = picture_of(static_cast<std::uint32_t>(*name));
        handed_over += name + text_of_picture(picture) + "\n";
        pictures.take(name, picture);
    }
    // It leaves "d" unread, which resets its connection.
    REQUIRE(write(all_are_handed_over[1], "d", 1) == 1);
    wait_for_a_child_to_end();
    pictures.finish();
    for (const int end : all_are_handed_over) close(end);
    CHECK(back == handed_over);
    CHECK(here == "cd");
}
