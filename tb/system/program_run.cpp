#include "program_run.h"

#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <sstream>
#include <stdexcept>

#include "tools/program/exit_status.h"

namespace metabuffer::test {
namespace {

/// A word for the shell that means just itself.
std::string quoted(const std::string& word) {
    std::string result = "'";
    for (const char letter : word) {
        result += letter == '\'' ? std::string("'\\''") : std::string(1, letter);
    }
    return result + "'";
}

}  // namespace

bool ProgramResult::complains_in_one_line() const {
    return err.size() > 1 && err.back() == '\n' && std::count(err.begin(), err.end(), '\n') == 1;
}

ProgramResult run_program(const ScratchDirectory& scratch, const std::vector<std::string>& arguments) {
    return run_program(METABUFFER_PROGRAM, scratch, arguments);
}

void check_refused(const ProgramResult& result, const std::vector<std::string>& words) {
    INFO("stderr: " << result.err);
    CHECK(result.status == kExitBadInput);
    CHECK(result.complains_in_one_line());
    CHECK(result.out.empty());
    for (const std::string& word : words) CHECK_THAT(result.err, Catch::Matchers::Contains(word));
}

ProgramResult run_script(const ScratchDirectory& scratch, const std::string& script) {
    return run_program("/bin/sh", scratch, {"-c", script, METABUFFER_PROGRAM});
}

ProgramResult run_program(const std::filesystem::path& program, const ScratchDirectory& scratch,
                          const std::vector<std::string>& arguments) {
    std::string command = "cd " + quoted(scratch.path().string()) + " && " + quoted(program.string());
    for (const std::string& argument : arguments) command += " " + quoted(argument);
    const std::filesystem::path out = scratch / ".stdout";
    const std::filesystem::path err = scratch / ".stderr";
    command += " > " + quoted(out.string()) + " 2> " + quoted(err.string());
    const int status = std::system(command.c_str());
    return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, text_of(out), text_of(err)};
}

std::string text_of(const std::filesystem::path& file) {
    std::ifstream stream(file, std::ios::binary);
    if (!stream) {
        throw std::runtime_error("cannot read " + file.string());
    }
    return {std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>()};
}

Waveform::Waveform(const std::filesystem::path& file) {
    std::istringstream text(text_of(file));
    std::vector<std::string> scopes;
    std::int64_t time = -1;
    for (std::string line; std::getline(text, line);) {
        std::istringstream words(line);
        std::string word;
        words >> word;
        if (word == "$scope") {
            std::string kind;
            words >> kind >> word;
            scopes.push_back(word);
        } else if (word == "$upscope") {
            scopes.pop_back();
        } else if (word == "$var") {
            read_variable(line, scopes);
        } else if (line.find("initial values are dumped below at time") != std::string::npos) {
            // "... at time 0.5 sec = 500000000000 timescale units."
            time = first_time_ = last_time_ = std::stoll(line.substr(line.find('=') + 1));
        } else if (word.size() > 1 && word[0] == '#') {
            time = std::stoll(word.substr(1));
        } else if (word.size() > 1 && (word[0] == '0' || word[0] == '1')) {
            changes_[word.substr(1)].push_back({time, word[0]});
            last_time_ = time;
        } else if (word.size() > 1 && word[0] == 'b') {
            last_time_ = time;
        }
    }
}

void Waveform::read_variable(const std::string& line, const std::vector<std::string>& scopes) {
    std::istringstream words(line);
    std::string word;
    std::string kind;
    std::string width;
    std::string identifier;
    std::string name;
    words >> word >> kind >> width >> identifier >> name;
    // The writer's own scope and the machine's say nothing.
    std::string path;
    for (const std::string& scope : scopes) {
        if (scope != "SystemC" && scope != "metabuffer") path += scope + ".";
    }
    identifiers_[path + name] = identifier;
}

std::vector<std::string> Waveform::names() const {
    std::vector<std::string> names;
    names.reserve(identifiers_.size());
    for (const auto& entry : identifiers_) names.push_back(entry.first);
    return names;
}

std::int64_t Waveform::first_change(const std::string& name, char from, char to) const {
    const auto identifier = identifiers_.find(name);
    if (identifier == identifiers_.end()) return -1;
    const auto changes = changes_.find(identifier->second);
    if (changes == changes_.end()) return -1;
    char before = 0;
    for (const Change& change : changes->second) {
        if (before == from && change.value == to) return change.time;
        before = change.value;
    }
    return -1;
}

std::int64_t Waveform::first_rise(const std::string& name) const { return first_change(name, '0', '1'); }
std::int64_t Waveform::first_fall(const std::string& name) const { return first_change(name, '1', '0'); }

}  // namespace metabuffer::test
