#include "rtl/waveform_file.h"

#include <fcntl.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <string>
#include <string_view>

#include "host/errors.h"
#include "support/scratch_directory.h"

// A process at the other end of a pipe writes the waveform. The test takes the role of SystemC's writer.
namespace metabuffer::test {
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
        file.start();
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
        file.start();
        const int pipe = opened(file);
        file.note_opened();
        close(pipe);
        file.put_in_place();
    }
    CHECK(fcntl(STDIN_FILENO, F_GETFD) != -1);
    CHECK(std::signal(SIGPIPE, SIG_DFL) == ignore_signal);
}

TEST_CASE("waveform file: a signal while nothing has come yet does not keep the writer waiting") {
    const ScratchDirectory scratch;
    be_a_process_group();
    struct sigaction interrupting {};
    interrupting.sa_handler = ignore_signal;  // without SA_RESTART
    REQUIRE(sigaction(SIGUSR1, &interrupting, nullptr) == 0);
    WaveformFile file(scratch / "interrupted.vcd", kHeader);
    file.start();
    const int pipe = opened(file);
    file.note_opened();
    // Its writer is waiting by the last of them at the latest.
    for (int i = 0; i < 20; ++i) {
        usleep(10'000);
        kill(0, SIGUSR1);
    }
    put(pipe, "all");
    close(pipe);
    file.put_in_place();
    CHECK(text_of(scratch / "interrupted.vcd") == "$comment\n" + std::string(kHeader) + "$end\nall");
}

TEST_CASE("waveform file: the error of a killed writer says how it ended") {
    const ScratchDirectory scratch;
    scratch.write("killed.vcd", "an earlier one");
    be_a_process_group();
    WaveformFile file(scratch / "killed.vcd", kHeader);
    file.start();
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
}  // namespace metabuffer::test
