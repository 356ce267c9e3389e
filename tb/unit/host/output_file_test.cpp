#include "host/output_file.h"

#include <unistd.h>

#include <catch2/catch.hpp>
#include <string>

#include "host/errors.h"
#include "host/text_file.h"
#include "support/file_size_limit.h"
#include "support/scratch_directory.h"

using namespace metabuffer;
using test::ScratchDirectory;
namespace fs = std::filesystem;

namespace {

/// The message of the OutputError that writing throws, "" if it throws none.
std::string failure_of(const fs::path& file, const std::string& bytes = "text") {
    try {
        write_output_file(file, bytes);
    } catch (const OutputError& error) {
        return error.what();
    }
    return "";
}

}  // namespace

TEST_CASE("a file is written as it is, over an older one too, and under a name of the greatest length",
          "[output]") {
    const ScratchDirectory scratch;
    const std::string bytes("{\r\n\0 end", 8);
    write_output_file(scratch / "report.json", bytes);
    CHECK(input::text_of_file(scratch / "report.json") == bytes);
    write_output_file(scratch / "report.json", "");
    CHECK(fs::file_size(scratch / "report.json") == 0);
    CHECK(scratch.names() == std::vector<std::string>{"report.json"});
    fs::remove(scratch / "report.json");
    const std::string name(255, 'n');
    write_output_file(scratch / name, "text");
    CHECK(scratch.names() == std::vector<std::string>{name});
    const fs::path longer = scratch / (name + "n");
    CHECK(failure_of(longer) == "cannot write '" + longer.string() + "': File name too long");
}

TEST_CASE("a failure to write is one line and leaves what was there", "[output]") {
    const ScratchDirectory scratch;

    SECTION("the directory does not exist") {
        const fs::path file = scratch / "missing/report.json";
        CHECK(failure_of(file) == "cannot write '" + file.string() + "': No such file or directory");
        CHECK(scratch.names().empty());
    }
    SECTION("a file stands where a directory should be") {
        scratch.write("plain", "kept");
        const fs::path file = scratch / "plain/report.json";
        CHECK(failure_of(file) == "cannot write '" + file.string() + "': Not a directory");
        CHECK(input::text_of_file(scratch / "plain") == "kept");
    }
    SECTION("a directory stands where the file should be") {
        const fs::path file = scratch / "report.json";
        fs::create_directories(file / "inside");
        CHECK(failure_of(file) == "cannot write '" + file.string() + "': Is a directory");
        CHECK(scratch.names() == std::vector<std::string>{"report.json"});
        CHECK(fs::exists(file / "inside"));
    }
    SECTION("the disk is full") {
        const fs::path file = scratch.write("report.json", "the old report");
        const test::FileSizeLimit limit(1000);
        CHECK(failure_of(file, std::string(1000, 'x')).empty());
        CHECK(failure_of(file, std::string(1001, 'y')) ==
              "cannot write '" + file.string() + "': File too large");
        CHECK(input::text_of_file(file) == std::string(1000, 'x'));
        CHECK(scratch.names() == std::vector<std::string>{"report.json"});
    }
}

TEST_CASE("a symbolic link leads to the file that is written, one at the temporary name never does",
          "[output]") {
    const ScratchDirectory scratch;

    SECTION("a link at the file's own name stays") {
        scratch.write("old", "the old report");
        const std::string leads_to = GENERATE("old", "not there yet");
        fs::create_symlink(leads_to, scratch / "report.json");
        write_output_file(scratch / "report.json", "new");
        CHECK(input::text_of_file(scratch / leads_to) == "new");
        CHECK(fs::is_symlink(scratch / "report.json"));
    }
    SECTION("a link at the temporary name stays, and the file that it leads to") {
        const fs::path stranger = scratch.write("stranger", "kept");
        const fs::path aside = scratch / (".metabuffer-" + std::to_string(getpid()) + "-0.part");
        fs::create_symlink(stranger, aside);
        write_output_file(scratch / "report.json", "new");
        CHECK(input::text_of_file(scratch / "report.json") == "new");
        CHECK(input::text_of_file(stranger) == "kept");
        CHECK(fs::is_symlink(aside));
    }
    SECTION("links that lead to each other") {
        fs::create_symlink("b", scratch / "a");
        fs::create_symlink("a", scratch / "b");
        CHECK(failure_of(scratch / "a") ==
              "cannot write '" + (scratch / "a").string() + "': Too many levels of symbolic links");
    }
    SECTION("a device is refused") {
        fs::create_symlink("/dev/null", scratch / "a");
        CHECK(failure_of(scratch / "a") == "cannot write '" + (scratch / "a").string() +
                                               "': it is no regular file; name a file in a folder");
    }
}
