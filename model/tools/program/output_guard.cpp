#include "tools/program/output_guard.h"

#include <algorithm>
#include <system_error>

#include "host/errors.h"
#include "host/text.h"

namespace metabuffer {

std::vector<std::filesystem::path> inputs_of(const std::filesystem::path& scenario_file,
                                             const Scenario& scenario) {
    std::vector<std::filesystem::path> inputs{scenario_file};
    for (const auto& [image, files] : scenario.image_files) {
        inputs.push_back(files.image);
        if (files.depth.has_value()) inputs.push_back(*files.depth);
    }
    for (const DisplayCorrection& correction : scenario.displays.correction) {
        if (!correction.lut_file.empty()) inputs.push_back(correction.lut_file);
    }
    return inputs;
}

void refuse_to_replace(const std::vector<std::filesystem::path>& inputs, const char* option,
                       const std::filesystem::path& output) {
    const auto replaced =
        std::find_if(inputs.begin(), inputs.end(), [&output](const std::filesystem::path& input) {
            std::error_code different;
            return std::filesystem::equivalent(input, output, different);
        });
    if (replaced == inputs.end()) return;
    throw InputError(std::string(option) + ": " + text::quoted(output.string()) + " would replace " +
                     text::quoted(replaced->string()) + ", which is read; name another");
}

}  // namespace metabuffer
