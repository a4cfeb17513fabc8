#include "options/settle_picture.hpp"

#include "options/first_view.hpp"

namespace ringsplat::app {

void settle_picture(const OptionList& list, RenderOptions& o) {
  settle_fit(list, o);
  o.frame.how = method_for(o.method);
  note_fixed_shortcuts(list, o.budget);
  if (o.budget.max_error && !o.error.truth) o.error.truth = TruthKind::method;
  o.budget.to_field = o.budget.max_error && *o.error.truth == TruthKind::field;
  // A method's truth is its own, so that only the field's tells which engine is nearer.
  if (o.budget.to_field && !engine_is_chosen(list)) o.budget.other_engine = method_for_other_engine(o.method);
}

}  // namespace ringsplat::app
