#pragma once

#include <unistd.h>

#include <fstream>
#include <iterator>
#include <string>
#include <vector>

namespace metabuffer::test {

/// The processes that a process has started; without a number this one.
inline std::vector<pid_t> children_of(pid_t process = getpid()) {
    const std::string pid = std::to_string(process);
    std::ifstream stream("/proc/" + pid + "/task/" + pid + "/children");
    return {std::istream_iterator<pid_t>(stream), {}};
}

}  // namespace metabuffer::test
