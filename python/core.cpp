// The extension module metabuffer._core: each function runs the program's work in a process of its own, and returns
// (status, text, crashed). The package around it, python/metabuffer, makes Python values and exceptions of that.
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <optional>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "build_info/build_info.h"
#include "process_call.h"
#include "requests.h"

/// SystemC's library needs this symbol. Only SystemC's own main() calls it, which a module does not run.
extern "C" __attribute__((visibility("default"))) int sc_main(int /*argc*/, char** /*argv*/) { return 0; }

namespace {

namespace py = pybind11;
using namespace metabuffer::python;

using Settings = std::vector<std::pair<std::string, std::string>>;
/// Status, text, and whether the process has ended without an answer. The text is bytes, since file names may hold any.
using Answer = std::tuple<int, py::bytes, bool>;

Answer answer(const std::function<Reply()>& work, const std::vector<int>& kept_descriptors = {}) {
    const CallResult result = call_in_process(work, kept_descriptors);
    return {static_cast<int>(result.reply.status), py::bytes(result.reply.text), result.crashed};
}

std::vector<metabuffer::ScenarioOverride> overrides_of(const Settings& settings) {
    std::vector<metabuffer::ScenarioOverride> overrides;
    overrides.reserve(settings.size());
    for (const auto& [path, value] : settings) overrides.push_back({path, value});
    return overrides;
}

Answer run_call(std::string file, std::optional<std::string> text, const Settings& settings,
                std::string level, bool images, bool check, int pictures) {
    const RunCall call{{std::move(file), std::move(text)},
                       overrides_of(settings),
                       std::move(level),
                       images,
                       check,
                       pictures};
    return answer([&call] { return run(call); }, {pictures});
}

Answer analyze_call(std::string file, std::optional<std::string> text, const Settings& settings,
                    std::optional<double> frame_rate_hz) {
    const Source scenario{std::move(file), std::move(text)};
    const std::vector<metabuffer::ScenarioOverride> overrides = overrides_of(settings);
    return answer([&] { return analyze(scenario, overrides, frame_rate_hz); });
}

Answer sweep_call(std::string file, std::optional<std::string> text, std::string out,
                  std::optional<int> processes, std::optional<double> time_limit, std::string level,
                  bool quiet) {
    const Source source{std::move(file), std::move(text)};
    const ExplorationCall call{std::move(out), processes, time_limit, std::move(level), quiet};
    return answer([&] { return sweep(source, call); });
}

Answer size_call(std::string file, const Settings& settings, std::string minimize,
                 std::vector<std::string> over, std::string goal, std::optional<double> frame_rate_hz,
                 std::optional<int> checks, std::string out, std::optional<int> processes,
                 std::optional<double> time_limit, std::string level, bool quiet) {
    const SizeCall call{std::move(file), overrides_of(settings), std::move(minimize),
                        std::move(over), std::move(goal),        frame_rate_hz,
                        checks};
    const ExplorationCall exploration{std::move(out), processes, time_limit, std::move(level), quiet};
    return answer([&] { return size(call, exploration); });
}

Answer results_call(const std::string& file, const std::string& where, const std::string& columns) {
    return answer([&] { return results(file, where, columns); });
}

}  // namespace

PYBIND11_MODULE(_core, module) {
    module.doc() = "The program's work, each call in a process of its own; use the package metabuffer.";
    module.attr("version") = METABUFFER_MODULE_VERSION;
    module.attr("build") = metabuffer::build_version();
    using py::arg;
    module.def("run", run_call, arg("file"), arg("text"), arg("settings"), arg("level"), arg("images"),
               arg("check"), arg("pictures"));
    module.def("analyze", analyze_call, arg("file"), arg("text"), arg("settings"), arg("frame_rate_hz"));
    module.def("sweep", sweep_call, arg("file"), arg("text"), arg("out"), arg("processes"), arg("time_limit"),
               arg("level"), arg("quiet"));
    module.def("size", size_call, arg("file"), arg("settings"), arg("minimize"), arg("over"), arg("goal"),
               arg("frame_rate_hz"), arg("checks"), arg("out"), arg("processes"), arg("time_limit"),
               arg("level"), arg("quiet"));
    module.def("results", results_call, arg("file"), arg("where"), arg("columns"));
}
