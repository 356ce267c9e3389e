#include "rtl/fst_converter.h"

#include <catch2/catch.hpp>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

#include "host/errors.h"
#include "host/output_file.h"
#include "support/scratch_directory.h"

// GTKWave's vcd2fst does not notice a full disk, so its output is checked. Here another program has its name.
namespace metabuffer::test::fst_converter_test {
namespace {

using rtl::FstConverter;

std::string text_of(const std::filesystem::path& file) {
    std::ifstream stream(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(stream), {}};
}

/// PATH leads to a vcd2fst that reads all its input, writes the file that the test wants, and notes the file's path.
class Bench {
  public:
    Bench() {
        std::filesystem::create_directory(temporary());
        setenv("PATH", scratch_.path().c_str(), 1);
        setenv("TMPDIR", temporary().c_str(), 1);
    }

    std::filesystem::path temporary() const { return scratch_ / "temporary"; }
    std::filesystem::path target() const { return scratch_ / "target.fst"; }
    std::filesystem::path given() const { return scratch_ / "given"; }
    /// The path that vcd2fst was asked to write to.
    std::filesystem::path asked_for() const { return text_of(scratch_ / "asked_for"); }

    /// The error if the program writes these bytes; empty if there is none.
    std::string error_of(const std::string& made) {
        return error_with("cp " + scratch_.write("made", made).string() + " \"$2\"");
    }
    std::string error_with(const std::string& command) {
        const auto program = scratch_.write(
            "vcd2fst", "#!/bin/sh\nPATH=/usr/bin:/bin\ncat > " + given().string() + "\nprintf %s \"$2\" > " +
                           (scratch_ / "asked_for").string() + "\n" + command + "\n");
        std::filesystem::permissions(program, std::filesystem::perms::owner_all);
        OutputFile output(target());
        try {
            FstConverter converter;
            converter.write("a dump ");
            converter.write("in two parts");
            converter.finish(output);
            output.put_in_place();
        } catch (const OutputError& error) {
            return error.what();
        }
        return "";
    }

  private:
    ScratchDirectory scratch_;
};

/// A section of an FST file: its kind, the length of the rest with these eight bytes, and its content.
std::string section(char kind, const std::string& content) {
    constexpr std::size_t kLengthBytes = 8;
    std::string bytes(1, kind);
    const std::uint64_t length = content.size() + kLengthBytes;
    for (int shift = 56; shift >= 0; shift -= 8) bytes += static_cast<char>(length >> shift & 0xFFU);
    return bytes + content;
}

TEST_CASE("FST converter: the dump is its input, the file is its output, and nothing else is left") {
    Bench bench;
    // A section whose length needs more than one byte, one without content, and a last one.
    const std::string made = section(0, std::string(300, 'h')) + section(1, "") + section(4, "hierarchy");
    CHECK(bench.error_of(made).empty());
    CHECK(text_of(bench.given()) == "a dump in two parts");
    CHECK(text_of(bench.target()) == made);
    CHECK(bench.asked_for().parent_path().parent_path() == bench.temporary());
    CHECK(std::filesystem::is_empty(bench.temporary()));
}

TEST_CASE("FST converter: a file of any length reaches its output to the last byte") {
    Bench bench;
    constexpr std::size_t kBlock = std::size_t{1} << 16;  // what is copied at a time
    const std::size_t empty = section(0, "").size();
    for (const std::size_t bytes : {kBlock - 1, kBlock, kBlock + 1, 2 * kBlock + 1}) {
        INFO(bytes << " bytes");
        const std::string made = section(0, std::string(bytes - empty, 'v'));
        CHECK(bench.error_of(made).empty());
        CHECK(text_of(bench.target()) == made);
    }
}

TEST_CASE("FST converter: a file that ends within a section is half a file, wherever it ends") {
    Bench bench;
    const std::string first = section(0, "header");
    const std::string made = first + section(1, "values and places");
    REQUIRE(bench.error_of(made).empty());
    std::filesystem::remove(bench.target());
    for (std::size_t bytes = 0; bytes < made.size(); ++bytes) {
        if (bytes == first.size()) continue;
        INFO(bytes << " of " << made.size() << " bytes");
        CHECK(bench.error_of(made.substr(0, bytes)).find("left half a file") != std::string::npos);
    }
    CHECK_FALSE(std::filesystem::exists(bench.target()));
    CHECK(std::filesystem::is_empty(bench.temporary()));
}

TEST_CASE("FST converter: a section that was not finished has no length, and the file is half a file") {
    Bench bench;
    const std::string unfinished = std::string(1, 'u') + std::string(8, '\0') + "values";
    CHECK(bench.error_of(unfinished).find("left half a file") != std::string::npos);
    CHECK(bench.error_of(section(0, "header") + unfinished).find("left half a file") != std::string::npos);
}

TEST_CASE("FST converter: a length that does not include its own eight bytes is none") {
    Bench bench;
    // Each would lead to a section without content at the file's end: from the length's last byte, and its first.
    const std::string head(8, '\0');
    CHECK(bench.error_of(head + '\7' + section(0, "").substr(1)).find("left half a file") !=
          std::string::npos);
    CHECK(bench.error_of(head + '\0' + '\10').find("left half a file") != std::string::npos);
    CHECK(bench.error_of(head + '\10').empty());
}

TEST_CASE("FST converter: a converter that makes no file, or fails, is an error") {
    Bench bench;
    CHECK(bench.error_with("true").find("left half a file") != std::string::npos);
    CHECK(bench.error_with("echo no room >&2; exit 1").find("no room") != std::string::npos);
    CHECK_FALSE(std::filesystem::exists(bench.target()));
}

}  // namespace
}  // namespace metabuffer::test::fst_converter_test
