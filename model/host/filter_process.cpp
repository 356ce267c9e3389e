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
#include <cstdlib>
#include <sstream>
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

}  // namespace

/// The running program, and this end of the pipes of its three streams.
struct FilterProcess::Running {
    explicit Running(const FilterProgram& program);
    Running(const Running&) = delete;
    Running& operator=(const Running&) = delete;
    ~Running();

    pid_t process = -1;
    Descriptor input;
    Descriptor output;
    Descriptor complaints;
};

FilterProcess::Running::Running(const FilterProgram& program) {
    Pipe to_input(program);
    Pipe from_output(program);
    Pipe from_complaints(program);
    SpawnPlan plan;
    plan.connect(to_input.reading.number(), STDIN_FILENO);
    plan.connect(from_output.writing.number(), STDOUT_FILENO);
    plan.connect(from_complaints.writing.number(), STDERR_FILENO);
    std::vector<std::string> words = program.command;
    std::vector<char*> arguments;
    arguments.reserve(words.size() + 1);
    for (std::string& word : words) arguments.push_back(word.data());
    arguments.push_back(nullptr);
    const int error = posix_spawnp(&process, arguments.front(), plan.actions(), plan.attributes(),
                                   arguments.data(), environ);
    if (error == ENOENT || error == EACCES) {
        fail(program, "no such program on this computer, and " + program.needed_by +
                          " needs it; install Debian's package " + program.package);
    }
    if (error != 0) fail(program, "cannot be started: " + std::generic_category().message(error));
    input = std::move(to_input.writing);
    output = std::move(from_output.reading);
    complaints = std::move(from_complaints.reading);
    fcntl(input.number(), F_SETFL, O_NONBLOCK);
}

namespace {

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

/// Sends as much as fits; closes if the program reads no more.
void send(Descriptor& descriptor, std::string_view& rest) {
    const ssize_t count = write(descriptor.number(), rest.data(), rest.size());
    if (count >= 0) {
        rest.remove_prefix(static_cast<std::size_t>(count));
    } else if (errno != EAGAIN && errno != EINTR) {
        descriptor.reset();
    }
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

/// The line that says most: node prints it as "Error: ..." between lines that say where it happened.
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

FilterProcess::Running::~Running() {
    if (process < 0) return;
    kill(process, SIGKILL);
    wait_for(process);
}

FilterProcess::FilterProcess(const FilterProgram& program)
    : program_(program), running_(std::make_unique<Running>(program)) {}

FilterProcess::~FilterProcess() = default;

void FilterProcess::feed(std::string_view input) {
    const WithoutBrokenPipeSignal no_signal;
    while (!input.empty() && running_->input.is_open()) exchange(input);
}

std::string FilterProcess::finish() {
    running_->input.reset();
    std::string_view nothing;
    while (running_->output.is_open() || running_->complaints.is_open()) exchange(nothing);
    const int status = wait_for(std::exchange(running_->process, -1));
    if (WIFEXITED(status) && WEXITSTATUS(status) == 0) return std::move(output_);
    const std::string complaint = first_complaint(complaints_);
    fail(program_, complaint.empty() ? "failed" : "failed: " + complaint);
}

/// Waits until something can be sent or received, and does so.
void FilterProcess::exchange(std::string_view& input) {
    // poll() ignores a negative descriptor.
    std::array<pollfd, 3> polled{{{running_->input.number(), POLLOUT, 0},
                                  {running_->output.number(), POLLIN, 0},
                                  {running_->complaints.number(), POLLIN, 0}}};
    if (poll(polled.data(), polled.size(), -1) < 0) {
        if (errno == EINTR) return;
        fail(program_, std::generic_category().message(errno));
    }
    if (polled[0].revents != 0) send(running_->input, input);
    if (polled[1].revents != 0) receive(running_->output, output_);
    if (polled[2].revents != 0) receive(running_->complaints, complaints_);
}

std::string filtered(const FilterProgram& program, const std::string& input) {
    FilterProcess process(program);
    process.feed(input);
    return process.finish();
}

bool is_installed(const FilterProgram& program) {
    const char* const path = std::getenv("PATH");
    std::istringstream folders(path != nullptr ? path : "");
    for (std::string folder; std::getline(folders, folder, ':');) {
        const std::string file = (folder.empty() ? "." : folder) + "/" + program.command.front();
        if (access(file.c_str(), X_OK) == 0) return true;
    }
    return false;
}

}  // namespace metabuffer
