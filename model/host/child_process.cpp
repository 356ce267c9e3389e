#include "host/child_process.h"

#include <fcntl.h>
#include <sys/ioctl.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <climits>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <iostream>
#include <system_error>
#include <thread>

#include "host/errors.h"
#include "host/quiet_fork.h"

namespace metabuffer {
namespace {

std::string how_it_ended(int status) {
    if (WIFSIGNALED(status)) return std::string("ended by a signal: ") + strsignal(WTERMSIG(status));
    return "ended with exit status " + std::to_string(WEXITSTATUS(status)) + " and without a report";
}

[[noreturn]] void fail_to_start(const char* what) {
    throw InputError(std::string("metabuffer: no ") + what +
                     " for a run: " + std::generic_category().message(errno));
}

[[noreturn]] void be_the_child(const ChildProcess::Work& work, int descriptor, pid_t parent) {
    // A run that nobody waits for must end, however its parent ended.
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    if (getppid() != parent) _exit(EXIT_FAILURE);
    int status = EXIT_SUCCESS;
    try {
        work(ChildProcess::Sender(descriptor));
    } catch (...) {
        status = EXIT_FAILURE;
    }
    // Flushes what the kernel printed. The parent's destructors must not run here.
    std::cout.flush();
    std::fflush(nullptr);
    _exit(status);
}

}  // namespace

void ChildProcess::Sender::send(const void* bytes, std::size_t count) const {
    const char* at = static_cast<const char*>(bytes);
    while (count > 0) {
        const ssize_t written = write(descriptor_, at, count);
        if (written < 0 && errno == EINTR) continue;
        if (written <= 0) _exit(EXIT_FAILURE);
        at += written;
        count -= static_cast<std::size_t>(written);
    }
}

ChildProcess::ChildProcess(const Work& work) {
    std::array<int, 2> ends{};
    if (pipe2(ends.data(), O_CLOEXEC) != 0) fail_to_start("pipe");
    // Otherwise both processes would print what is still in the buffers.
    std::cout.flush();
    std::fflush(nullptr);
    const pid_t parent = getpid();
    process_ = quiet_fork();
    if (process_ == 0) {
        close(ends[0]);
        be_the_child(work, ends[1], parent);
    }
    const int error = errno;
    close(ends[1]);
    if (process_ < 0) {
        close(ends[0]);
        errno = error;
        fail_to_start("process");
    }
    descriptor_ = ends[0];
}

ChildProcess::~ChildProcess() {
    if (ended()) return;
    kill(process_, SIGKILL);
    waitpid(process_, nullptr, 0);
    close(descriptor_);
}

void ChildProcess::receive(std::string& bytes) {
    int waiting = 0;
    ioctl(descriptor_, FIONREAD, &waiting);
    const std::size_t before = bytes.size();
    bytes.resize(before + static_cast<std::size_t>(std::max(waiting, 1)));
    const ssize_t got = read(descriptor_, &bytes[before], bytes.size() - before);
    bytes.resize(before + static_cast<std::size_t>(std::max<ssize_t>(got, 0)));
    if (got == 0 || (got < 0 && errno != EINTR)) reap();
}

void ChildProcess::ask_to_end() const {
    if (!ended()) kill(process_, SIGTERM);
}

void close_descriptors_but(std::vector<int> kept) {
    std::sort(kept.begin(), kept.end());
    unsigned first = STDERR_FILENO + 1;
    for (const int one : kept) {
        const auto descriptor = static_cast<unsigned>(one);
        if (one < 0 || descriptor < first) continue;
        if (descriptor > first) close_range(first, descriptor - 1, 0);
        first = descriptor + 1;
    }
    close_range(first, UINT_MAX, 0);
}

std::size_t helper_process_count() {
    const unsigned cores = std::thread::hardware_concurrency();
    return cores > 1 ? cores : 0;
}

void ChildProcess::reap() {
    close(descriptor_);
    descriptor_ = -1;
    int status = 0;
    while (waitpid(process_, &status, 0) < 0 && errno == EINTR) {
    }
    if (!WIFEXITED(status) || WEXITSTATUS(status) != EXIT_SUCCESS) complaint_ = how_it_ended(status);
}

}  // namespace metabuffer
