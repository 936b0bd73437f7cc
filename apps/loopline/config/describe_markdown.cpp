/// The catalogue as pages of the manual: docs/ini-reference.md is describe_all_as_markdown().
#include "config/catalogue.h"
#include "config/ini_text.h"

namespace loopline {
namespace {

const char* const introduction = R"(# .ini reference

Made by `loopline describe --markdown > docs/ini-reference.md`; a test fails when it is stale.

An experiment is one .ini file: `[section]` headers and `key = value` lines. Comments start with `;`, `#` or `//`, at the
start of a line or after a blank; a value in double quotes is taken as it stands. Every key has a default, so an .ini names
only what differs; `[run]` must name `rawlog` (or the command line does, by `--rawlog`) and `modules`.

- Keys carry their unit: `_m _s _ms _deg _hz _mps _dps _mb`; those without one are dimensionless.
- Relative paths are taken from the folder of the .ini, those on the command line from the working directory.
  `${NAME}` is an environment variable; `${LOOPLINE_DATA}`, the folder of downloaded logs, is `../shared/data` where it is
  unset and that folder is there.
- `--set section.key=value` replaces a value, or adds it; the last one counts.
- Each module and map builder that is named in `[run]` reads the section of its name. An .ini may also hold the section of a
  module that it does not use, so that `--set run.modules=...` can switch methods; its keys and values are checked all the
  same. A `--set` for a module that is not used is refused, since it would have no effect.
- An unknown section or key, a wrong value, anything that stands there twice: all are reported together, each with file:line
  and the nearest known name; the exit code is 2 (3 if only a log is missing), and nothing is written.
- A scenario, as in `datasets/`, is an .ini file of the same form with sections of its own. A key that takes rows of numbers may
  stand there several times; `--set` replaces all of its rows by one, or by none if there is no value.
- `config.ini` in a run directory holds every key with the value that counted, and repeats the run.
)";

std::string escaped(const std::string& text) {
    std::string result;
    for (const char c : text) {
        if (c == '|') result += '\\';
        result += c;
    }
    return result;
}

std::string observation_list(const std::string& title, const std::vector<std::string>& classes) {
    std::string text;
    for (const auto& name : classes) text += (text.empty() ? "\n" + title + ": " : ", ") + ("`" + name + "`");
    return text.empty() ? text : text + "\n";
}

std::string group(const Catalogue& catalogue, SectionKind kind, const std::string& title) {
    std::string text = "\n## " + title + "\n";
    bool any = false;
    for (const auto& entry : catalogue.entries()) {
        if (entry.kind != kind) continue;
        any = true;
        text += "\n" + describe_as_markdown(entry);
    }
    return any ? text : text + "\nNone.\n";
}

}  // namespace

std::string describe_as_markdown(const CatalogueEntry& entry) {
    std::string text = "### [" + entry.info.name + "]\n\n" + entry.info.sentence + "\n";
    text += observation_list("Needs", entry.info.needs) + observation_list("Uses", entry.info.uses) +
            observation_list("Publishes", entry.info.publishes);
    if (entry.table.parameters().empty()) return text + "\nIt has no keys.\n";
    text += "\n| key | default | unit | allowed | what it does |\n| --- | --- | --- | --- | --- |\n";
    for (const auto& p : entry.table.parameters())
        text += "| `" + p.name + "` | " +
                (p.default_text.empty() ? "" : "`" + escaped(p.default_text) + "`") + " | " + p.unit + " | " +
                escaped(p.allowed.empty() ? kind_text(p.kind) : p.allowed) + " | " + escaped(p.sentence) +
                " |\n";
    return text;
}

std::string describe_all_as_markdown(const Catalogue& catalogue) {
    return introduction + group(catalogue, SectionKind::host, "Sections of the host") +
           group(catalogue, SectionKind::module, "Modules, for `[run] modules`") +
           group(catalogue, SectionKind::map_builder, "Map builders, for `[run] maps`") +
           group(catalogue, SectionKind::scenario, "Sections of a scenario, for `loopline simulate`") +
           group(catalogue, SectionKind::import_file,
                 "Sections of a column map, for `loopline import csv` ([how](column-maps.md))");
}

}  // namespace loopline
