/// Which class an object is of, for those who ask it of every observation.
#pragma once

#include <mrpt/rtti/CObject.h>

#include <memory>

namespace loopline {

/// The object as a `Class`, or null: dynamic_cast by MRPT's own run-time types, for a tenth of the time.
template <class Class>
const Class* as(const mrpt::rtti::CObject* object) {
    const auto* const wanted = &Class::GetRuntimeClassIdStatic();
    for (const auto* id = object->GetRuntimeClass(); id != nullptr;
         id = id->getBaseClass != nullptr ? id->getBaseClass() : nullptr)
        if (id == wanted) return static_cast<const Class*>(object);
    return nullptr;
}
template <class Class>
Class* as(mrpt::rtti::CObject* object) {
    return const_cast<Class*>(as<Class>(static_cast<const mrpt::rtti::CObject*>(object)));
}
template <class Class, class Base>
std::shared_ptr<Class> as(const std::shared_ptr<Base>& object) {
    Class* const pointer = as<Class>(object.get());
    return pointer != nullptr ? std::shared_ptr<Class>(object, pointer) : nullptr;
}

}  // namespace loopline
