"""Parts under load: a beam of N scales on its supports, its forces and moments."""
