#include "rtl/waveform_file.h"

#include <fcntl.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <cerrno>
#include <csignal>
#include <cstddef>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <string_view>

#include "host/errors.h"
#include "support/scratch_directory.h"

// A process at the other end of a pipe writes the waveform. The test takes the role of SystemC's writer.
namespace metabuffer::test::waveform_file_test {
namespace {

using rtl::WaveformFile;

constexpr const char* kHeader = "made by a test\n";

std::string text_of(const std::filesystem::path& file) {
    std::ifstream stream(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(stream), {}};
}

/// Opens the pipe by its name, as SystemC's writer does.
int opened(const WaveformFile& file) {
    const int descriptor = open((file.stem() + ".vcd").c_str(), O_WRONLY | O_CLOEXEC);
    REQUIRE(descriptor >= 0);
    return descriptor;
}

void put(int descriptor, std::string_view bytes) {
    REQUIRE(write(descriptor, bytes.data(), bytes.size()) == static_cast<ssize_t>(bytes.size()));
}

void ignore_signal(int /*number*/) {}

/// From here on a signal to this process and those that it starts reaches no other process.
void be_a_process_group() {
    setpgid(0, 0);
    REQUIRE(getpgrp() == getpid());
}

TEST_CASE("waveform file: what comes is written behind the header, even a single byte") {
    const ScratchDirectory scratch;
    for (const std::string bytes : {"x", "$var wire 1 ! clk $end\n"}) {
        WaveformFile file(scratch / "short.vcd", kHeader);
        file.start(0);
        const int pipe = opened(file);
        file.note_opened();
        put(pipe, bytes);
        close(pipe);
        file.put_in_place();
        CHECK(text_of(scratch / "short.vcd") == "$comment\n" + std::string(kHeader) + "$end\n" + bytes);
    }
}

TEST_CASE("waveform file: it leaves the process as it was, its signals and its standard input") {
    const ScratchDirectory scratch;
    const int null = open("/dev/null", O_RDONLY | O_CLOEXEC);
    REQUIRE(dup2(null, STDIN_FILENO) == STDIN_FILENO);
    REQUIRE(std::signal(SIGPIPE, ignore_signal) != SIG_ERR);
    {
        WaveformFile file(scratch / "left.vcd", kHeader);
        file.start(0);
        const int pipe = opened(file);
        file.note_opened();
        close(pipe);
        file.put_in_place();
    }
    CHECK(fcntl(STDIN_FILENO, F_GETFD) != -1);
    CHECK(std::signal(SIGPIPE, SIG_DFL) == ignore_signal);
}

TEST_CASE("waveform file: a process without a standard input writes one, too") {
    const ScratchDirectory scratch;
    WaveformFile file(scratch / "without.vcd", kHeader);
    close(STDIN_FILENO);
    file.start(0);
    const int pipe = opened(file);
    file.note_opened();
    put(pipe, "all");
    close(pipe);
    file.put_in_place();
    CHECK(text_of(scratch / "without.vcd") == "$comment\n" + std::string(kHeader) + "$end\nall");
}

TEST_CASE(
    "waveform file: signals while the writer waits, for the simulation or for more bytes, change nothing") {
    const ScratchDirectory scratch;
    be_a_process_group();
    struct sigaction interrupting {};
    interrupting.sa_handler = ignore_signal;  // without SA_RESTART
    REQUIRE(sigaction(SIGUSR1, &interrupting, nullptr) == 0);
    // Its writer is waiting by the last of them at the latest.
    const auto send_signals = [] {
        for (int i = 0; i < 12; ++i) {
            usleep(10'000);
            kill(0, SIGUSR1);
        }
    };
    WaveformFile file(scratch / "interrupted.vcd", kHeader);
    file.start(0);
    send_signals();
    const int pipe = opened(file);
    file.note_opened();
    put(pipe, "all");
    send_signals();
    put(pipe, " of it");
    close(pipe);
    file.put_in_place();
    CHECK(text_of(scratch / "interrupted.vcd") == "$comment\n" + std::string(kHeader) + "$end\nall of it");
}

TEST_CASE(
    "waveform file: without a folder for its pipe, or without the pipe, the error names file and cause") {
    const ScratchDirectory scratch;
    const auto error_of_start = [&scratch] {
        WaveformFile file(scratch / "none.vcd", kHeader);
        try {
            file.start(0);
        } catch (const OutputError& error) {
            return std::string(error.what());
        }
        return std::string("no error");
    };
    const std::string no_pipe = "cannot write '" + (scratch / "none.vcd").string() + "': no pipe for it: ";
    REQUIRE(setenv("TMPDIR", "/proc", 1) == 0);  // nobody can make a folder there
    CHECK(error_of_start() == no_pipe + "No such file or directory");
    // There is room for the folder's name, but not for the pipe's.
    constexpr std::size_t kLongestName = 4095;
    const std::string own_folder = "/metabuffer-XXXXXX";
    std::string folder = scratch.path().string();
    while (folder.size() + own_folder.size() < kLongestName) {
        const std::size_t left = kLongestName - own_folder.size() - folder.size();
        folder += left > 100 ? '/' + std::string(99, 'f') : std::string(left, 'f');
    }
    CAPTURE(folder.size());
    REQUIRE(std::filesystem::create_directories(folder));
    REQUIRE(setenv("TMPDIR", folder.c_str(), 1) == 0);
    CHECK(error_of_start() == no_pipe + "File name too long");
    CHECK(std::filesystem::is_empty(folder));
    CHECK_FALSE(std::filesystem::exists(scratch / "none.vcd"));
}

/// The descriptor of the pipe that the next waveform file reads.
int pipe_to_lose = -1;
void lose_pipe(int /*number*/) { close(pipe_to_lose); }

TEST_CASE("waveform file: if its writer cannot read the pipe, that is the error, and an earlier file stays") {
    const ScratchDirectory scratch;
    scratch.write("unread.vcd", "an earlier one");
    be_a_process_group();
    WaveformFile file(scratch / "unread.vcd", kHeader);
    pipe_to_lose = dup(STDIN_FILENO);  // the lowest one that is free
    REQUIRE(pipe_to_lose >= 0);
    close(pipe_to_lose);
    struct sigaction losing {};
    losing.sa_handler = lose_pipe;  // without SA_RESTART
    REQUIRE(sigaction(SIGUSR1, &losing, nullptr) == 0);
    file.start(0);
    REQUIRE(std::signal(SIGUSR1, ignore_signal) != SIG_ERR);  // only in this process
    const int pipe = opened(file);
    file.note_opened();
    kill(0, SIGUSR1);
    CHECK_THROWS_WITH(file.put_in_place(), "the waveform's pipe: Bad file descriptor");
    close(pipe);
    CHECK(text_of(scratch / "unread.vcd") == "an earlier one");
}

TEST_CASE("waveform file: the error of a killed writer says how it ended") {
    const ScratchDirectory scratch;
    scratch.write("killed.vcd", "an earlier one");
    be_a_process_group();
    WaveformFile file(scratch / "killed.vcd", kHeader);
    file.start(0);
    const int pipe = opened(file);
    file.note_opened();
    REQUIRE(std::signal(SIGTERM, ignore_signal) != SIG_ERR);  // only in this process
    kill(0, SIGTERM);
    close(pipe);
    CHECK_THROWS_WITH(file.put_in_place(), Catch::Contains("killed.vcd") && Catch::Contains("its process") &&
                                               Catch::Contains("Terminated"));
    CHECK(text_of(scratch / "killed.vcd") == "an earlier one");
}

TEST_CASE("waveform file: only a compressed waveform needs the converter, and says so before the run") {
    const ScratchDirectory scratch;
    REQUIRE(setenv("PATH", scratch.path().c_str(), 1) == 0);
    CHECK_NOTHROW(WaveformFile(scratch / "plain.vcd", kHeader));
    CHECK_THROWS_WITH(WaveformFile(scratch / "packed.fst", kHeader), Catch::Contains("gtkwave"));
}

}  // namespace
}  // namespace metabuffer::test::waveform_file_test
