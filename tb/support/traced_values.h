#pragma once

#include <algorithm>
#include <cstddef>
#include <map>
#include <sstream>
#include <string>
#include <systemc>
#include <vector>

#include "support/lines.h"
#include "support/scratch_directory.h"

namespace metabuffer::test {

/// What a waveform shows of the values that `trace` adds to it, in its order: name[bits]=value, as unsigned, or x.
template <typename Trace>
std::vector<std::string> traced_by(const Trace& trace) {
    const ScratchDirectory scratch;
    sc_core::sc_trace_file* const file = sc_core::sc_create_vcd_trace_file((scratch / "values").c_str());
    trace(file);
    sc_core::sc_start(1, sc_core::SC_NS);
    sc_core::sc_close_vcd_trace_file(file);
    std::map<std::string, std::size_t> indices;  // by identifier
    std::vector<std::string> traced;
    std::vector<std::string> scopes;
    bool in_values = false;
    for (const std::string& line : lines_of_file(scratch / "values.vcd")) {
        std::istringstream stream(line);
        std::string keyword, type, width, identifier, name;
        stream >> keyword;
        in_values = in_values || keyword == "$dumpvars";
        if (keyword == "$scope") {
            stream >> type >> name;
            scopes.push_back(name);
        } else if (keyword == "$upscope") {
            scopes.pop_back();
        } else if (keyword == "$var") {
            stream >> type >> width >> identifier >> name;
            for (std::size_t i = scopes.size(); i > 1; --i) name.insert(0, scopes[i - 1] + ".");
            indices[identifier] = traced.size();
            traced.push_back(name.append("[").append(width).append("]="));
        } else if (in_values && keyword[0] == 'b') {
            stream >> identifier;
            const bool is_number = keyword.find('x') == std::string::npos;
            traced.at(indices.at(identifier)) +=
                is_number ? std::to_string(std::stoull(keyword.substr(1), nullptr, 2)) : "x";
        } else if (in_values && (keyword[0] == '0' || keyword[0] == '1')) {
            traced.at(indices.at(keyword.substr(1))) += keyword[0];
        }
    }
    return traced;
}

/// The same of all that a block adds to a waveform.
template <typename Block>
std::vector<std::string> traced_values(const Block& block) {
    return traced_by([&block](sc_core::sc_trace_file* file) { block.trace(file); });
}

/// Whether that has one of the block's registers, without the block's name before it, with this value.
template <typename Block>
bool shows(const Block& block, const std::string& register_value) {
    const std::vector<std::string> values = traced_values(block);
    return std::count(values.begin(), values.end(), block.name() + ("." + register_value)) == 1;
}

}  // namespace metabuffer::test
