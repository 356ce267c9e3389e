#pragma once

#include <filesystem>
#include <fstream>
#include <istream>
#include <sstream>
#include <string>
#include <vector>

namespace metabuffer::test {

inline std::vector<std::string> lines_of(std::istream& stream) {
    std::vector<std::string> lines;
    for (std::string line; std::getline(stream, line);) lines.push_back(line);
    return lines;
}

inline std::vector<std::string> lines_of(const std::string& text) {
    std::istringstream stream(text);
    return lines_of(stream);
}

/// None if the file is not there.
inline std::vector<std::string> lines_of_file(const std::filesystem::path& file) {
    std::ifstream stream(file);
    return lines_of(stream);
}

}  // namespace metabuffer::test
