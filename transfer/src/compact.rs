//! Compact sparse rows: the narrowest exact widths.
