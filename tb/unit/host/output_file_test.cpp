#include "host/output_file.h"

#include <sys/resource.h>

#include <catch2/catch.hpp>
#include <csignal>
#include <fstream>
#include <iterator>
#include <string>

#include "host/errors.h"
#include "support/scratch_directory.h"

using namespace metabuffer;
using test::ScratchDirectory;
namespace fs = std::filesystem;

namespace {

std::string content(const fs::path& file) {
    std::ifstream stream(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>()};
}

/// The message of the OutputError that writing throws, "" if it throws none.
std::string failure_of(const fs::path& file, const std::string& bytes = "text") {
    try {
        write_output_file(file, bytes);
    } catch (const OutputError& error) {
        return error.what();
    }
    return "";
}

/// Files may hold so many bytes while it lives, as with a disk that is full after them.
class FileSizeLimit {
  public:
    explicit FileSizeLimit(rlim_t bytes) {
        std::signal(SIGXFSZ, SIG_IGN);
        getrlimit(RLIMIT_FSIZE, &before_);
        rlimit limit = before_;
        limit.rlim_cur = bytes;
        REQUIRE(setrlimit(RLIMIT_FSIZE, &limit) == 0);
    }
    FileSizeLimit(const FileSizeLimit&) = delete;
    FileSizeLimit& operator=(const FileSizeLimit&) = delete;
    ~FileSizeLimit() {
        setrlimit(RLIMIT_FSIZE, &before_);
        std::signal(SIGXFSZ, SIG_DFL);
    }

  private:
    rlimit before_{};
};

}  // namespace

TEST_CASE("a file is written as it is, over an older one too", "[output]") {
    const ScratchDirectory scratch;
    const std::string bytes("{\r\n\0 end", 8);
    write_output_file(scratch / "report.json", bytes);
    CHECK(content(scratch / "report.json") == bytes);
    write_output_file(scratch / "report.json", "");
    CHECK(fs::file_size(scratch / "report.json") == 0);
    CHECK(scratch.names() == std::vector<std::string>{"report.json"});
}

TEST_CASE("a name as long as the file system takes it is no longer aside", "[output]") {
    const ScratchDirectory scratch;
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
        CHECK(content(scratch / "plain") == "kept");
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
        const FileSizeLimit limit(1000);
        CHECK(failure_of(file, std::string(1000, 'x')).empty());
        CHECK(failure_of(file, std::string(1001, 'y')) ==
              "cannot write '" + file.string() + "': File too large");
        CHECK(content(file) == std::string(1000, 'x'));
        CHECK(scratch.names() == std::vector<std::string>{"report.json"});
    }
}

TEST_CASE("nothing is written through a symbolic link", "[output]") {
    const ScratchDirectory scratch;
    const fs::path stranger = scratch.write("stranger", "kept");

    SECTION("at the file's own name") { fs::create_symlink(stranger, scratch / "report.json"); }
    SECTION("at the name that the file has aside") {
        fs::create_symlink(stranger, scratch / (".metabuffer-" + std::to_string(getpid()) + "-0.part"));
    }
    write_output_file(scratch / "report.json", "new");
    CHECK(content(scratch / "report.json") == "new");
    CHECK_FALSE(fs::is_symlink(scratch / "report.json"));
    CHECK(content(stranger) == "kept");
}
