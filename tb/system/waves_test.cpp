#include <algorithm>
#include <catch2/catch.hpp>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <nlohmann/json.hpp>
#include <regex>
#include <sstream>
#include <string>
#include <vector>

#include "program_run.h"
#include "support/lines.h"

namespace metabuffer::test::waves_test {

namespace {

constexpr std::int64_t kCorePeriodPicoseconds = 10000;  // 100 MHz, the scenarios' default

const std::filesystem::path kSource = METABUFFER_SOURCE_DIRECTORY;

bool begins_with(const std::string& text, const std::string& beginning) {
    return text.compare(0, beginning.size(), beginning) == 0;
}

std::vector<std::filesystem::path> save_files() {
    std::vector<std::filesystem::path> files;
    for (const auto& entry : std::filesystem::directory_iterator(kSource / "waves")) {
        if (entry.path().extension() == ".gtkw") files.push_back(entry.path());
    }
    std::sort(files.begin(), files.end());
    return files;
}

/// A GTKWave save file, as far as it matters here.
struct SaveFile {
    std::vector<std::string> signals;  ///< as GTKWave looks for them
    std::int64_t marker_picoseconds = -1;
    std::int64_t start_picoseconds = -1;

    explicit SaveFile(const std::filesystem::path& file) {
        for (const std::string& line : lines_of(text_of(file))) {
            INFO(line);
            std::istringstream rest(line);
            std::string word;
            if (begins_with(line, "+{")) {
                signals.push_back(line.substr(line.find("} ") + 2));
            } else if (begins_with(line, "*")) {
                rest >> word >> marker_picoseconds;
            } else if (begins_with(line, "[timestart]")) {
                rest >> word >> start_picoseconds;
            } else {
                // The path where it was saved must not be in it.
                CHECK_FALSE(begins_with(line, "[dumpfile"));
                CHECK_FALSE(begins_with(line, "[savefile"));
                // Options, formats, words for values, group names and the room below an analog trace.
                CHECK((line.empty() || line[0] == '[' || line[0] == '@' || line[0] == '^' || line[0] == '-'));
            }
        }
    }
};

/// A value change dump with its values.
class ValueDump {
  public:
    explicit ValueDump(const std::filesystem::path& file) {
        std::string scope;
        bool in_comment = false;
        for (const std::string& line : lines_of(text_of(file))) {
            std::istringstream words(line);
            std::string word;
            words >> word;
            if (word == "$comment" || in_comment) {
                in_comment = line.find("$end") == std::string::npos;
                if (in_comment && word != "$comment") comment_.push_back(line);
            } else if (word == "$scope") {
                words >> word >> word;
                scope += word + ".";
            } else if (word == "$upscope") {
                scope.erase(scope.rfind('.', scope.size() - 2) + 1);
            } else if (word == "$var") {
                add_variable(words, scope);
            } else if (word.size() > 1 && word[0] == '#') {
                last_time_ = std::stoll(word.substr(1));
                if (first_time_ < 0) first_time_ = last_time_;
            } else if (word.size() > 1 && word[0] == 'b') {
                std::string identifier;
                words >> identifier;
                add_change(identifier, std::stoull(word.substr(1), nullptr, 2));
            } else if (word.size() > 1 && (word[0] == '0' || word[0] == '1')) {
                add_change(word.substr(1), word[0] == '1' ? 1 : 0);
            }
        }
    }

    /// The lines of its comments.
    const std::vector<std::string>& comment() const { return comment_; }
    /// The names that has() knows.
    std::vector<std::string> names() const {
        std::vector<std::string> names;
        for (const auto& [name, variable] : variables_) names.push_back(name);
        return names;
    }
    /// Of the first and the last change within the dump.
    std::int64_t first_time() const { return first_time_; }
    std::int64_t last_time() const { return last_time_; }

    /// A name as GTKWave has it: scopes, dots, the range of a vector.
    bool has(const std::string& name) const { return variables_.count(name) != 0; }
    /// A name below the machine, without range.
    bool has_short(const std::string& name) const { return short_names_.count(name) != 0; }

    /// What the signal shows from a time on.
    std::uint64_t at(const std::string& short_name, std::int64_t time) const {
        const Variable& variable = variables_.at(short_names_.at(short_name));
        std::uint64_t value = 0;
        for (const Change& change : changes_.at(variable.identifier)) {
            if (change.time > time) break;
            value = change.value;
        }
        return value;
    }
    /// How long a signal of one bit is high in the dump.
    std::int64_t picoseconds_high(const std::string& short_name) const {
        std::int64_t sum = 0;
        std::int64_t rise = -1;
        for (const Change& change : changes_.at(variables_.at(short_names_.at(short_name)).identifier)) {
            if (rise >= 0) sum += change.time - rise;
            rise = change.value != 0 ? change.time : -1;
        }
        return rise >= 0 ? sum + last_time_ - rise : sum;
    }
    /// A number as the page writes it, in the signal's width.
    std::uint64_t value_from_text(const std::string& short_name, const std::string& text) const {
        const int width = variables_.at(short_names_.at(short_name)).width;
        const std::uint64_t mask = width < 64 ? (std::uint64_t{1} << width) - 1 : ~std::uint64_t{0};
        return static_cast<std::uint64_t>(std::stoll(text, nullptr, 0)) & mask;
    }

  private:
    struct Variable {
        std::string identifier;
        int width = 0;
    };
    struct Change {
        std::int64_t time = 0;
        std::uint64_t value = 0;
    };

    void add_variable(std::istringstream& words, const std::string& scope) {
        std::string type;
        std::string name;
        std::string range;
        Variable variable;
        words >> type >> variable.width >> variable.identifier >> name >> range;
        const std::string full = scope + name + (range == "$end" ? "" : range);
        variables_[full] = variable;
        const std::string machine = "SystemC.metabuffer.";
        if (begins_with(full, machine)) short_names_[(scope + name).substr(machine.size())] = full;
    }
    void add_change(const std::string& identifier, std::uint64_t value) {
        changes_[identifier].push_back({last_time_, value});
    }

    std::vector<std::string> comment_;
    std::int64_t first_time_ = -1;
    std::int64_t last_time_ = -1;
    std::map<std::string, Variable> variables_;
    std::map<std::string, std::string> short_names_;
    std::map<std::string, std::vector<Change>> changes_;
};

/// A section of waves/README.md: a waveform and what is said of it.
struct PageSection {
    struct Event {
        std::int64_t clock = 0;
        std::string signal;
        std::string before;  ///< empty: it is not said to change
        std::string value;
    };

    std::string title;
    std::vector<std::string> arguments;  ///< of the program
    std::string waveform;
    std::string save_file;  ///< empty: shown without
    std::vector<Event> events;
};

std::vector<std::string> words_of(const std::string& command) {
    std::istringstream stream(command);
    std::vector<std::string> words;
    for (std::string word; stream >> word;) {
        word.erase(std::remove(word.begin(), word.end(), '\''), word.end());
        words.push_back(word);
    }
    return words;
}

void read_command(const std::string& command, PageSection& section) {
    std::vector<std::string> words = words_of(command);
    if (words.at(0) == "gtkwave") {
        section.waveform = words.at(1);
        if (words.size() > 2) section.save_file = words[2];
        return;
    }
    REQUIRE(words[0] == "build/release/metabuffer");
    REQUIRE(section.arguments.empty());
    words.erase(words.begin());
    for (std::string& word : words) {
        if (begins_with(word, "scenarios/")) word = (kSource / word).string();
    }
    section.arguments = words;
}

/// The sections that have a command.
std::vector<PageSection> read_page() {
    const std::regex row(R"(\| (\d+) \| `([^`]+)` \| (?:(\S+) to )?(\S+) \|.*)");
    std::vector<PageSection> sections;
    bool in_commands = false;
    std::string command;
    for (const std::string& line : lines_of(text_of(kSource / "waves/README.md"))) {
        if (begins_with(line, "## ")) {
            sections.emplace_back();
            sections.back().title = line.substr(3);
        } else if (begins_with(line, "```")) {
            in_commands = line == "```sh";
        } else if (in_commands) {
            command += line;
            if (command.back() == '\\') {
                command.pop_back();
                continue;
            }
            read_command(command, sections.back());
            command.clear();
        } else if (std::smatch cells; std::regex_match(line, cells, row)) {
            sections.back().events.push_back({std::stoll(cells[1]), cells[2], cells[3], cells[4]});
        }
    }
    const auto no_command = [](const PageSection& section) { return section.arguments.empty(); };
    sections.erase(std::remove_if(sections.begin(), sections.end(), no_command), sections.end());
    return sections;
}

void check_event(const ValueDump& dump, const PageSection::Event& event) {
    INFO("clock " << event.clock << ", " << event.signal << ": " << event.before << " to " << event.value);
    const std::int64_t time = event.clock * kCorePeriodPicoseconds;
    REQUIRE(dump.has_short(event.signal));
    CHECK(time > dump.first_time());
    CHECK(time <= dump.last_time());
    CHECK(dump.at(event.signal, time) == dump.value_from_text(event.signal, event.value));
    if (!event.before.empty()) {
        CHECK(dump.at(event.signal, time - kCorePeriodPicoseconds) ==
              dump.value_from_text(event.signal, event.before));
    }
}

}  // namespace

/// How wide registers are depends on the machine: the settings that the page gives with a save file.
std::vector<std::string> settings_with(const std::filesystem::path& save_file) {
    std::vector<std::string> settings;
    for (const PageSection& section : read_page()) {
        if (std::filesystem::path(section.save_file).filename() != save_file.filename()) continue;
        for (std::size_t i = 0; i + 1 < section.arguments.size(); ++i) {
            const std::string& option = section.arguments[i];
            if (option == "--set") settings.insert(settings.end(), {option, section.arguments[i + 1]});
        }
        break;
    }
    return settings;
}

/// Runs a scenario, which leaves a waveform in the folder.
void run_traced(const ScratchDirectory& scratch, const std::filesystem::path& scenario,
                const std::string& options, const std::vector<std::string>& more = {}) {
    std::vector<std::string> words{"run", scenario.string(), "--quiet", "--no-images"};
    for (const std::string& word : words_of(options)) words.push_back(word);
    words.insert(words.end(), more.begin(), more.end());
    const ProgramResult result = run_program(scratch, words);
    INFO(result.err);
    REQUIRE(result.status == 0);
}

const std::filesystem::path kFirstCase = kSource / "scenarios/case-1.yaml";

/// Of a scenario's first clocks.
ValueDump dump_of(const std::string& scenario, const std::vector<std::string>& settings) {
    const ScratchDirectory scratch;
    run_traced(scratch, kSource / "scenarios" / scenario,
               "--frames 1 --trace first.vcd --trace-window cycles:0-20", settings);
    return ValueDump(scratch / "first.vcd");
}

TEST_CASE("Every signal of the save files is in the waveform", "[waves][repeat]") {
    REQUIRE(!save_files().empty());
    std::map<std::vector<std::string>, ValueDump> dumps;
    for (const std::filesystem::path& file : save_files()) {
        INFO(file.filename().string());
        const std::vector<std::string> settings = settings_with(file);
        if (dumps.count(settings) == 0) dumps.emplace(settings, dump_of("paper-figure.yaml", settings));
        const SaveFile save(file);
        CHECK(!save.signals.empty());
        for (const std::string& signal : save.signals) {
            INFO(signal);
            CHECK(dumps.at(settings).has(signal));
        }
    }
}

/// Writes the names that a waveform has beside those that the list has, so that one can be put in the other's place.
void check_names(const ValueDump& dump, const std::string& machine) {
    const std::filesystem::path wanted = kSource / "tb/system/waveforms" / (machine + ".txt");
    const std::vector<std::string> names = dump.names();
    std::string text;
    for (const std::string& name : names) text += name + '\n';
    const std::string list = text_of(wanted);
    if (text == list) return;
    const std::filesystem::path found = std::filesystem::current_path() / (machine + "_signals.txt");
    std::ofstream(found) << text;
    const std::vector<std::string> listed = lines_of(list);
    std::vector<std::string> differences;
    std::set_symmetric_difference(names.begin(), names.end(), listed.begin(), listed.end(),
                                  std::back_inserter(differences));
    for (const std::string& name : differences) UNSCOPED_INFO(name);
    FAIL_CHECK("the waveform has other signals than " << wanted.string() << "; if that is meant: cp "
                                                      << found.string() << ' ' << wanted.string());
}

TEST_CASE("Every register and wire of a machine is in the waveform, as wide as it must be",
          "[waves][repeat]") {
    const std::vector<std::string> small{"--set", "displays.columns=1", "--set", "displays.rows=1"};
    check_names(dump_of("case-1.yaml", small), "defaults");
    std::vector<std::string> all = small;
    // Numbers of 2^k - 1 take all bits that they have: one more, and a register would need another.
    for (const char* setting :
         {"links.layer=tmds", "displays.width=129", "displays.height=127", "bus.arbitration=edf",
          "bus.burst_pixels=31", "bus.grant_cycles=2", "bus.register_stages=1", "memory.ports=shared",
          "memory.banks=4", "memory.page_miss_cycles=7", "memory.precharge_cycles=2",
          "memory.words_per_cycle=8", "memory.read_latency_cycles=4", "memory.refresh_cycles=15",
          "memory.refresh_interval_cycles=511", "composer.buffer_pixels=1023", "composer.smoothing=bilinear",
          "composer.on_starvation=stall"}) {
        all.insert(all.end(), {"--set", setting});
    }
    check_names(dump_of("case-1.yaml", all), "all-settings");
}

TEST_CASE("Every word of a beat is in the waveform, and no more than the bus has", "[waves][repeat]") {
    const auto dump_with = [](const std::string& width_bits) {
        return dump_of("case-1.yaml",
                       {"--set", "bus.width_bits=" + width_bits, "--set", "memory.words_per_cycle=4"});
    };
    const std::string word = "SystemC.metabuffer.input_framebuffer_1.BUS.word_";
    const ValueDump wide = dump_with("512");
    CHECK(wide.has(word + "3[63:0]"));
    CHECK_FALSE(wide.has(word + "4[63:0]"));
    const ValueDump narrow = dump_with("64");
    CHECK(narrow.has(word + "1[63:0]"));  // a table row has two words
    CHECK_FALSE(narrow.has(word + "2[63:0]"));
}

TEST_CASE("A waveform says which program, scenario and settings made it, and counts the core clocks",
          "[waves][repeat]") {
    const ScratchDirectory scratch;
    const std::filesystem::path faulty = scratch / "faulty.yaml";
    {
        std::string content = text_of(kSource / "scenarios/case-1.yaml");
        const std::size_t image = content.find("images/cases");
        REQUIRE(image != std::string::npos);
        content.insert(image, (kSource / "scenarios/").string());
        std::ofstream(faulty) << content
                              << "faults:\n  - {renderer: view, pair: 0, kind: delay, delay_pairs: 1}\n";
    }
    run_traced(
        scratch, faulty,
        "--trace counted.vcd --trace-window cycles:30-90 --set memory.banks=4 --set bus.burst_pixels=48",
        {"--set", "name=$end of 'it'"});
    const ValueDump dump(scratch / "counted.vcd");
    const auto says = [&dump](const std::string& line) {
        return std::count(dump.comment().begin(), dump.comment().end(), line) == 1;
    };
    CHECK(begins_with(dump.comment().at(0), "metabuffer "));
    CHECK(says("scenario ?end of 'it'"));
    const auto has = [&dump](const std::string& text) {
        return std::any_of(dump.comment().begin(), dump.comment().end(),
                           [&text](const std::string& line) { return line.find(text) != std::string::npos; });
    };
    CHECK(has("banks: 4"));
    CHECK(has("burst_pixels: 48"));
    CHECK(has("viewport: "));
    CHECK(has("kind: delay"));
    for (const std::int64_t clock : {40, 41, 90}) {
        CHECK(dump.at("core_cycle", clock * kCorePeriodPicoseconds) == static_cast<std::uint64_t>(clock));
        CHECK(dump.at("core_cycle", clock * kCorePeriodPicoseconds - 1) ==
              static_cast<std::uint64_t>(clock - 1));
    }
}

TEST_CASE("Every clock of the machine is in the waveform with its period, and so is reset",
          "[waves][repeat]") {
    const ValueDump dump =
        dump_of("case-1.yaml", {"--set", "clocks.dvi_in_mhz=50", "--set", "clocks.dvi_out_mhz=25"});
    const auto is_high = [](std::int64_t time, std::int64_t period) {
        return time % period < period / 2 ? 1U : 0U;  // all clocks rise at time 0
    };
    for (std::int64_t time = kCorePeriodPicoseconds / 4; time < dump.last_time();
         time += kCorePeriodPicoseconds / 2) {
        INFO(time << " ps");
        CHECK(dump.at("core_clk", time) == is_high(time, kCorePeriodPicoseconds));
        CHECK(dump.at("dvi_in_clk", time) == is_high(time, 2 * kCorePeriodPicoseconds));
        CHECK(dump.at("dvi_out_clk", time) == is_high(time, 4 * kCorePeriodPicoseconds));
    }
    CHECK(dump.at("reset", 0) == 1);
    CHECK(dump.at("reset", dump.last_time()) == 0);
}

TEST_CASE("The waveform counts the rows of the table that comes over a link", "[waves][repeat]") {
    const ScratchDirectory scratch;
    run_traced(scratch, kFirstCase, "--trace rows.vcd --trace-window cycles:0-2700");
    const ValueDump dump(scratch / "rows.vcd");
    CHECK(dump.at("input_framebuffer_1.table_unit.back_rows", dump.first_time()) == 0);
    CHECK(dump.at("input_framebuffer_1.table_unit.back_rows", dump.last_time()) == 1);
}

TEST_CASE("The waveform shows each pixel that starves for a clock, the frame's last among them",
          "[waves][repeat]") {
    const ScratchDirectory scratch;
    // So slow that all pixels at the end of the frame starve.
    run_traced(scratch, kFirstCase,
               "--frames 1 --trace starved.vcd --trace-window cycles:0-60000 --set bus.width_bits=64 "
               "--set memory.page_miss_cycles=60 --set memory.page_words=16");
    const ValueDump dump(scratch / "starved.vcd");
    const auto report = nlohmann::json::parse(text_of(scratch / "out/case-1/report.json"));
    for (const auto& composer : report["composers"]) {
        const std::string name = "composer_" + std::to_string(composer["renderer"].get<int>()) + "_" +
                                 std::to_string(composer["display"].get<int>());
        INFO(name);
        CHECK(dump.picoseconds_high(name + ".merge_stage.starved") ==
              composer["starved_pixels"].get<std::int64_t>() * kCorePeriodPicoseconds);
    }
    CHECK(report["totals"]["starved_pixels"] > 0);
    CHECK(report["composers"][0]["first_glitch"].is_object());
}

TEST_CASE("No register outgrows its width: the waveform of a whole frame has no unknown value",
          "[waves][repeat]") {
    const ScratchDirectory scratch;
    run_traced(scratch, kFirstCase,
               "--trace frame.vcd --trace-window cycles:0-55000 --trace-modules *_1,*_1_1 "
               "--set bus.arbitration=edf --set bus.grant_cycles=2 --set bus.register_stages=1 "
               "--set memory.read_latency_cycles=2 --set memory.refresh_cycles=20 "
               "--set memory.refresh_interval_cycles=400");
    // SystemC writes x for what does not fit.
    std::string unknown;
    for (const std::string& line : lines_of(text_of(scratch / "frame.vcd"))) {
        const std::string value = line.substr(0, line.find(' '));
        if (value.find_first_not_of("b01x") == std::string::npos && value.find('x') != std::string::npos) {
            unknown = line;
        }
    }
    CHECK(unknown.empty());
}

TEST_CASE("A compressed waveform holds what the other holds", "[waves][repeat]") {
    const ScratchDirectory scratch;
    const auto run_with = [&scratch](const std::string& file) {
        const ProgramResult result = run_program(
            scratch,
            {"run", kFirstCase.string(), "--no-images", "--trace", file, "--trace-window", "cycles:100-900"});
        INFO(result.err);
        REQUIRE(result.status == 0);
        CHECK(result.out.find("waveform " + file + ": core clocks 100 to 900") != std::string::npos);
    };
    run_with("plain.vcd");
    run_with("packed.fst");
    CHECK(std::filesystem::file_size(scratch / "packed.fst") <
          std::filesystem::file_size(scratch / "plain.vcd"));
    const ProgramResult unpacked =
        run_program("/usr/bin/fst2vcd", scratch, {"--extensions", "-f", "packed.fst", "-o", "unpacked.vcd"});
    INFO(unpacked.err);
    REQUIRE(unpacked.status == 0);
    const ValueDump plain(scratch / "plain.vcd");
    const ValueDump packed(scratch / "unpacked.vcd");
    CHECK(packed.last_time() == plain.last_time());
    // GTKWave's format leaves out the blanks that a line of a comment begins with.
    const auto trimmed = [](std::vector<std::string> lines) {
        for (std::string& line : lines) line.erase(0, line.find_first_not_of(" \t"));
        return lines;
    };
    std::vector<std::string> header = plain.comment();
    header.pop_back();  // SystemC's own line on the first values
    CHECK(trimmed(packed.comment()) == trimmed(header));
    CHECK(packed.comment().size() > 10);
    std::vector<std::string> names = packed.names();
    // SystemC's names of vectors have their range with and without a blank before it.
    for (std::string& name : names) name.erase(std::remove(name.begin(), name.end(), ' '), name.end());
    CHECK(names == plain.names());
    for (const std::string signal : {"core_cycle", "composer_1_1.BUSREADY", "input_framebuffer_1.BUS.kind",
                                     "input_framebuffer_1.bus_port.state"}) {
        INFO(signal);
        for (std::int64_t clock = 101; clock <= 900; ++clock) {
            const std::int64_t time = clock * kCorePeriodPicoseconds;
            REQUIRE(packed.at(signal, time) == plain.at(signal, time));
        }
    }
}

TEST_CASE("Without its converter there is no compressed waveform, but a line that says so",
          "[waves][repeat]") {
    const ScratchDirectory scratch;
    const ProgramResult result = run_program("/usr/bin/env", scratch,
                                             {"PATH=/nowhere", METABUFFER_PROGRAM, "run", kFirstCase.string(),
                                              "--quiet", "--no-images", "--trace", "packed.fst"});
    check_refused(result, {"install Debian's package gtkwave"});
    CHECK_FALSE(std::filesystem::exists(scratch / "packed.fst"));
}

TEST_CASE("A compressed waveform for which there is no room is an error, and nothing is left",
          "[waves][repeat]") {
    const ScratchDirectory scratch;
    std::filesystem::create_directory(scratch / "temporary");
    // The converter's files must not grow beyond 8 KiB; it does not notice itself, but is ended by a signal.
    const ProgramResult result =
        run_program("/bin/sh", scratch,
                    {"-c",
                     "ulimit -f 16; TMPDIR=temporary \"$0\" run \"$1\" --quiet --no-images --trace "
                     "packed.fst --trace-window cycles:0-3000",
                     METABUFFER_PROGRAM, kFirstCase.string()});
    CHECK(result.status == 2);
    CHECK(result.complains_in_one_line());
    CHECK_FALSE(std::filesystem::exists(scratch / "packed.fst"));
    CHECK(std::filesystem::is_empty(scratch / "temporary"));
}

TEST_CASE("The waveforms show what their page says", "[waves][slow]") {
    const std::vector<PageSection> sections = read_page();
    std::vector<std::string> shown;
    for (const PageSection& section : sections) {
        INFO(section.title);
        const ScratchDirectory scratch;
        const ProgramResult result = run_program(scratch, section.arguments);
        INFO(result.err);
        REQUIRE(result.status == 0);
        const ValueDump dump(scratch / section.waveform);
        CHECK(!section.events.empty());
        for (const PageSection::Event& event : section.events) {
            check_event(dump, event);
        }
        if (!section.save_file.empty()) {
            INFO(section.save_file);
            const SaveFile save(kSource / section.save_file);
            CHECK(save.start_picoseconds >= dump.first_time());
            CHECK(save.marker_picoseconds > save.start_picoseconds);
            CHECK(save.marker_picoseconds <= dump.last_time());
            shown.push_back(std::filesystem::path(section.save_file).filename().string());
        }
    }
    std::sort(shown.begin(), shown.end());
    std::vector<std::string> present;
    for (const std::filesystem::path& file : save_files()) present.push_back(file.filename().string());
    CHECK(shown == present);
}

}  // namespace metabuffer::test::waves_test
