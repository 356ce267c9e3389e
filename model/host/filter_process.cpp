#include "host/filter_process.h"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstddef>
#include <string_view>
#include <system_error>
#include <utility>

#include "host/errors.h"
#include "host/text.h"

namespace metabuffer {

namespace {

[[noreturn]] void fail(const FilterProgram& program, const std::string& what) {
    throw OutputError("metabuffer: " + program.command.front() + ": " + what);
}

class Descriptor {
  public:
    Descriptor() = default;
    explicit Descriptor(int number) : number_(number) {}
    Descriptor(Descriptor&& other) noexcept : number_(std::exchange(other.number_, -1)) {}
    Descriptor& operator=(Descriptor&& other) noexcept {
        std::swap(number_, other.number_);
        return *this;
    }
    ~Descriptor() { reset(); }

    int number() const { return number_; }
    bool is_open() const { return number_ >= 0; }
    void reset() {
        if (number_ >= 0) close(number_);
        number_ = -1;
    }

  private:
    int number_ = -1;
};

struct Pipe {
    explicit Pipe(const FilterProgram& program) {
        std::array<int, 2> ends{};
        if (pipe2(ends.data(), O_CLOEXEC) != 0) fail(program, std::generic_category().message(errno));
        reading = Descriptor(ends[0]);
        writing = Descriptor(ends[1]);
    }
    Descriptor reading;
    Descriptor writing;
};

/// posix_spawn's instructions.
class SpawnPlan {
  public:
    SpawnPlan() {
        posix_spawn_file_actions_init(&actions_);
        posix_spawnattr_init(&attributes_);
        // The program gets SIGPIPE as it expects, though this process may have it switched off.
        sigset_t signals;
        sigemptyset(&signals);
        sigaddset(&signals, SIGPIPE);
        posix_spawnattr_setsigdefault(&attributes_, &signals);
        posix_spawnattr_setflags(&attributes_, POSIX_SPAWN_SETSIGDEF);
    }
    SpawnPlan(const SpawnPlan&) = delete;
    SpawnPlan& operator=(const SpawnPlan&) = delete;
    ~SpawnPlan() {
        posix_spawnattr_destroy(&attributes_);
        posix_spawn_file_actions_destroy(&actions_);
    }

    void connect(int descriptor, int as) { posix_spawn_file_actions_adddup2(&actions_, descriptor, as); }
    const posix_spawn_file_actions_t* actions() const { return &actions_; }
    const posix_spawnattr_t* attributes() const { return &attributes_; }

  private:
    posix_spawn_file_actions_t actions_{};
    posix_spawnattr_t attributes_{};
};

/// The program at work, its three streams at this end of their pipes.
struct Running {
    pid_t process = -1;
    Descriptor input;
    Descriptor output;
    Descriptor complaints;
};

Running start(const FilterProgram& program) {
    Pipe input(program);
    Pipe output(program);
    Pipe complaints(program);
    SpawnPlan plan;
    plan.connect(input.reading.number(), STDIN_FILENO);
    plan.connect(output.writing.number(), STDOUT_FILENO);
    plan.connect(complaints.writing.number(), STDERR_FILENO);
    std::vector<std::string> words = program.command;
    std::vector<char*> arguments;
    arguments.reserve(words.size() + 1);
    for (std::string& word : words) arguments.push_back(word.data());
    arguments.push_back(nullptr);
    Running running;
    const int error = posix_spawnp(&running.process, arguments.front(), plan.actions(), plan.attributes(),
                                   arguments.data(), environ);
    if (error == ENOENT || error == EACCES) {
        fail(program, "no such program on this computer, and the chart needs it; install Debian's package " +
                          program.package);
    }
    if (error != 0) fail(program, "cannot be started: " + std::generic_category().message(error));
    running.input = std::move(input.writing);
    running.output = std::move(output.reading);
    running.complaints = std::move(complaints.reading);
    fcntl(running.input.number(), F_SETFL, O_NONBLOCK);
    return running;
}

/// Appends what is there; closes at the end.
void receive(Descriptor& descriptor, std::string& bytes) {
    std::array<char, 65536> chunk{};
    const ssize_t count = read(descriptor.number(), chunk.data(), chunk.size());
    if (count > 0) {
        bytes.append(chunk.data(), static_cast<std::size_t>(count));
    } else if (count == 0 || errno != EINTR) {
        descriptor.reset();
    }
}

/// Hands over as much as fits; closes at the end, or if the program reads no more.
void send(Descriptor& descriptor, std::string_view& rest) {
    const ssize_t count = write(descriptor.number(), rest.data(), rest.size());
    if (count >= 0) {
        rest.remove_prefix(static_cast<std::size_t>(count));
    } else if (errno != EAGAIN && errno != EINTR) {
        rest = {};
    }
    if (rest.empty()) descriptor.reset();
}

/// While it lives, writing to a program that has ended is an error instead of the end of this process.
class WithoutBrokenPipeSignal {
  public:
    WithoutBrokenPipeSignal() : before_(signal(SIGPIPE, SIG_IGN)) {}
    WithoutBrokenPipeSignal(const WithoutBrokenPipeSignal&) = delete;
    WithoutBrokenPipeSignal& operator=(const WithoutBrokenPipeSignal&) = delete;
    ~WithoutBrokenPipeSignal() { signal(SIGPIPE, before_); }

  private:
    void (*before_)(int);
};

/// The line that says most: node's come as "Error: ..." in the midst of where it happened.
std::string first_complaint(const std::string& complaints) {
    std::string first;
    std::size_t at = 0;
    while (at < complaints.size()) {
        const std::size_t end = std::min(complaints.find('\n', at), complaints.size());
        const std::string line = complaints.substr(at, end - at);
        if (line.find("Error: ") != std::string::npos && line.size() < 1000) return text::one_line(line);
        if (first.empty()) first = text::one_line(line.substr(0, 200));
        at = end + 1;
    }
    return first;
}

int wait_for(pid_t process) {
    int status = 0;
    while (waitpid(process, &status, 0) < 0 && errno == EINTR) {
    }
    return status;
}

}  // namespace

std::string filtered(const FilterProgram& program, const std::string& input) {
    const WithoutBrokenPipeSignal no_signal;
    Running running = start(program);
    std::string output;
    std::string complaints;
    std::string_view rest = input;
    while (running.output.is_open() || running.complaints.is_open()) {
        // A negative descriptor is one that poll() passes over.
        std::array<pollfd, 3> polled{{{running.input.number(), POLLOUT, 0},
                                      {running.output.number(), POLLIN, 0},
                                      {running.complaints.number(), POLLIN, 0}}};
        if (poll(polled.data(), polled.size(), -1) < 0 && errno != EINTR) break;
        if (polled[0].revents != 0) send(running.input, rest);
        if (polled[1].revents != 0) receive(running.output, output);
        if (polled[2].revents != 0) receive(running.complaints, complaints);
    }
    running.input.reset();
    const int status = wait_for(running.process);
    if (WIFEXITED(status) && WEXITSTATUS(status) == 0) return output;
    const std::string complaint = first_complaint(complaints);
    fail(program, complaint.empty() ? "failed" : "failed: " + complaint);
}

}  // namespace metabuffer
