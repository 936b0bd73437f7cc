#include "config/catalogue.h"

#include <algorithm>

#include "config/host_sections.h"
#include "config/ini_text.h"
#include "config/plugin_loader.h"

namespace loopline {

Catalogue::Catalogue() : defaults_(std::make_unique<Experiment>()) {
    load_plugins();
    for (auto& table : {run_table(defaults_->run), mount_table(defaults_->mount),
                        outputs_table(defaults_->outputs), evaluation_table(defaults_->evaluation)})
        entries_.push_back({SectionKind::host, {table.section(), table.sentence(), {}, {}, {}}, table});
    for (const auto& name : known_modules()) add(SectionKind::module, make_module(name));
    for (const auto& name : known_map_builders()) add(SectionKind::map_builder, make_map_builder(name));
    for (const auto& name : known_simulators()) {
        const Simulator::Ptr simulator = make_simulator(name);
        owners_.push_back(simulator);
        add_sections(SectionKind::scenario, simulator->sections());
    }
    for (const auto& name : known_importers()) {
        const Importer::Ptr importer = make_importer(name);
        owners_.push_back(importer);
        add_sections(SectionKind::import_file, importer->sections());
    }
}

void Catalogue::add_sections(SectionKind kind, const std::vector<ParameterTable>& tables) {
    for (const auto& table : tables)
        entries_.push_back({kind, {table.section(), table.sentence(), {}, {}, {}}, table});
}

void Catalogue::add(SectionKind kind, const Configurable::Ptr& owner) {
    owners_.push_back(owner);
    entries_.push_back({kind, owner->info(), owner->parameters()});
}

const CatalogueEntry* Catalogue::find(const std::string& name) const {
    const auto found =
        std::find_if(entries_.begin(), entries_.end(), [&](const auto& e) { return e.info.name == name; });
    return found == entries_.end() ? nullptr : &*found;
}

std::vector<std::string> Catalogue::names() const {
    std::vector<std::string> names;
    for (const auto& entry : entries_) names.push_back(entry.info.name);
    return names;
}

std::string describe_all_as_ini(const Catalogue& catalogue) {
    std::string text = "# Every section and key of loopline " LOOPLINE_VERSION
                       " at its default. [run] needs rawlog and modules.\n";
    for (const auto& entry : catalogue.entries())
        if (entry.kind != SectionKind::scenario && entry.kind != SectionKind::import_file)
            text += "\n" + ini_section_text(entry.table);
    return text;
}

}  // namespace loopline
