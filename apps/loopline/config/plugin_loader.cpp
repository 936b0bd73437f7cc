#include "config/plugin_loader.h"

#include <dlfcn.h>
#include <mrpt/core/demangle.h>
#include <mrpt/rtti/CObject.h>
#include <mrpt/system/os.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <map>

#include "commands/command.h"
#include "config/host_sections.h"
#include "config/paths.h"

namespace loopline {
namespace {

namespace fs = std::filesystem;
using ClassId = const mrpt::rtti::TRuntimeClassId*;

/// The file that a symbol's address belongs to.
std::string library_of(const void* address) {
    Dl_info info{};
    return dladdr(address, &info) && info.dli_fname ? info.dli_fname : "the program itself";
}

/// The loader's own words: MRPT puts dlerror() on the last line, behind the library's path.
std::string load_failure(std::string complaint, const std::string& path) {
    while (!complaint.empty() && complaint.back() == '\n') complaint.pop_back();
    complaint.erase(0, complaint.rfind('\n') + 1);
    if (complaint.rfind(path + ": ", 0) == 0) complaint.erase(0, path.size() + 2);
    const std::size_t mangled = complaint.find("_Z");
    return mangled == std::string::npos
               ? complaint
               : complaint.substr(0, mangled) + mrpt::demangle(complaint.substr(mangled));
}

bool same_file(const std::string& a, const std::string& b) {
    std::error_code none;
    return a == b || fs::equivalent(a, b, none);
}

std::map<std::string, ClassId> registered_classes() {
    std::map<std::string, ClassId> classes;
    for (const ClassId id : mrpt::rtti::getAllRegisteredClasses()) classes[id->className] = id;
    return classes;
}

/// MRPT lets the later of two classes with one name win, with a warning at most.
void refuse_duplicate_classes(const std::map<std::string, ClassId>& before) {
    const auto after = registered_classes();
    for (const auto& [name, id] : before) {
        const auto found = after.find(name);
        if (found == after.end() || found->second == id) continue;
        throw CommandError(exit_configuration, "the class " + name + " is in two plugins, " + library_of(id) +
                                                   " and " + library_of(found->second) +
                                                   "; remove one of them");
    }
}

/// dlsym() also looks into the libraries that this one needs: only its own symbol counts.
void refuse_other_version(const std::string& path) {
    void* library = dlopen(path.c_str(), RTLD_LAZY | RTLD_NOLOAD);
    void* symbol = library ? dlsym(library, "loopline_plugin_api_version") : nullptr;
    if (!symbol || !same_file(library_of(symbol), path))
        throw CommandError(exit_configuration,
                           path +
                               " is not a Loopline plugin: it does not say which version of the "
                               "plugin contract it was built for; move it out of the plugin folder");
    const std::string version = reinterpret_cast<const char* (*)()>(symbol)();
    if (version != LOOPLINE_API_VERSION)
        throw CommandError(exit_configuration, path + " was built for the plugin contract " + version +
                                                   ", and this program has " LOOPLINE_API_VERSION
                                                   "; build it again");
}

template <class Base>
std::vector<std::shared_ptr<Base>> one_of_each() {
    std::vector<std::shared_ptr<Base>> objects;
    for (const auto& [name, id] : registered_classes()) {
        if (!id->ptrCreateObject || !id->derivedFrom(CLASS_ID(Base))) continue;
        if (auto object = std::dynamic_pointer_cast<Base>(mrpt::rtti::CObject::Ptr(id->createObject())))
            objects.push_back(object);
    }
    return objects;
}

template <class Base>
std::shared_ptr<Base> made_by_name(const std::string& name) {
    for (auto& object : one_of_each<Base>())
        if (object->info().name == name) return object;
    return nullptr;
}

template <class Base>
std::vector<std::string> names_of_each() {
    std::vector<std::string> names;
    for (const auto& object : one_of_each<Base>()) names.push_back(object->info().name);
    std::sort(names.begin(), names.end());
    return names;
}

/// Each name is an .ini section: it must lead to one class.
void refuse_duplicate_names() {
    std::map<std::string, std::string> owners;
    for (const auto& section : host_section_names()) owners[section] = "the program itself";
    for (const auto& object : one_of_each<Configurable>()) {
        const std::string library = library_of(object->GetRuntimeClass());
        const auto [first, added] = owners.emplace(object->info().name, library);
        if (!added)
            throw CommandError(exit_configuration, "the name \"" + first->first + "\" is in use twice, by " +
                                                       first->second + " and by " + library +
                                                       "; remove one of them");
    }
}

fs::path plugin_folder() {
    if (const char* named = std::getenv("LOOPLINE_PLUGINS"); named && *named) return fs::absolute(named);
    return program_file().parent_path().parent_path() / "lib" / "loopline";
}

}  // namespace

void load_plugin(const std::string& relative_path) {
    const std::string path = fs::absolute(relative_path).lexically_normal().string();
    const auto before = registered_classes();
    std::string complaint;
    if (!mrpt::system::loadPluginModule(path, complaint)) {
        throw CommandError(exit_configuration, "the plugin " + path + " can't be loaded (" +
                                                   load_failure(complaint, path) +
                                                   "); build it again, or move it out of the plugin folder");
    }
    refuse_duplicate_classes(before);
    refuse_other_version(path);
    refuse_duplicate_names();
}

std::vector<std::string> load_plugins() {
    const fs::path folder = plugin_folder();
    std::error_code error;
    std::vector<std::string> libraries;
    // The library that holds the contract is the program's own, and no plugin.
    const std::string contract = library_of(CLASS_ID(Module));
    for (const auto& entry : fs::directory_iterator(folder, error))
        if (entry.path().extension() == ".so" && !same_file(entry.path().string(), contract))
            libraries.push_back(entry.path().string());
    if (error)
        throw CommandError(exit_configuration,
                           "the plugin folder " + folder.string() + " can't be read (" + error.message() +
                               "); install Loopline again, or set LOOPLINE_PLUGINS to its folder");
    std::sort(libraries.begin(), libraries.end());
    for (const auto& library : libraries) load_plugin(library);
    return libraries;
}

std::vector<std::string> known_modules() {
    return names_of_each<Module>();
}
std::vector<std::string> known_map_builders() {
    return names_of_each<MapBuilder>();
}
std::vector<std::string> known_importers() {
    return names_of_each<Importer>();
}
std::vector<std::string> known_simulators() {
    return names_of_each<Simulator>();
}
Module::Ptr make_module(const std::string& name) {
    return made_by_name<Module>(name);
}
MapBuilder::Ptr make_map_builder(const std::string& name) {
    return made_by_name<MapBuilder>(name);
}
Importer::Ptr make_importer(const std::string& name) {
    return made_by_name<Importer>(name);
}
Simulator::Ptr make_simulator(const std::string& name) {
    return made_by_name<Simulator>(name);
}

}  // namespace loopline
