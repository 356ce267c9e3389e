#include "host/quiet_fork.h"

#include <unistd.h>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <string>
#include <thread>

namespace metabuffer {
namespace {

#if defined(__SANITIZE_ADDRESS__)
constexpr bool kHasSanitizer = true;
#elif defined(__has_feature)
constexpr bool kHasSanitizer = __has_feature(address_sanitizer);
#else
constexpr bool kHasSanitizer = false;
#endif

/// Whether every other thread of this process sleeps.
bool other_threads_sleep() {
    const std::string own = std::to_string(gettid());
    for (const auto& task : std::filesystem::directory_iterator("/proc/self/task")) {
        if (task.path().filename() == own) continue;
        std::ifstream stream(task.path() / "stat");
        std::string stat;
        std::getline(stream, stat);  // empty if the thread has ended meanwhile
        // The state comes after the name, which may have any characters.
        const std::size_t name_end = stat.rfind(')');
        if (name_end != std::string::npos && stat.compare(name_end, 3, ") S") != 0) return false;
    }
    return true;
}

/// The threads have nothing to do once they have begun.
void let_threads_come_to_rest() {
    constexpr int kLooks = 2'000;
    constexpr int kQuietLooks = 3;
    for (int look = 0, quiet = 0; look < kLooks && quiet < kQuietLooks; ++look) {
        quiet = other_threads_sleep() ? quiet + 1 : 0;
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
}

}  // namespace

pid_t quiet_fork() {
    if (kHasSanitizer) let_threads_come_to_rest();
    return fork();
}

}  // namespace metabuffer
