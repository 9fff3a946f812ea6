// What is thrown: every error of the package is a SuppleError, and says where it is from and what to do.

export class SuppleError extends Error {
  constructor(message, { path, field, problem, cure } = {}) {
    super(message);
    this.name = new.target.name;
    this.path = path;
    this.field = field;
    this.problem = problem;
    this.cure = cure;
  }
}

/** A file that the one handed in asks for, and that a page does not have. */
export class FileError extends SuppleError {}
/** A file that is not what its format demands. */
export class FormatError extends SuppleError {}
/** An argument that cannot be used. */
export class InvalidError extends SuppleError {}
/** A linear system of a bake or a step that could not be solved. */
export class SolveError extends SuppleError {}
/** A result that is not finite; the avatar keeps the state before it. */
export class NotFiniteError extends SuppleError {}

const classes = { SuppleError, FileError, FormatError, InvalidError, SolveError, NotFiniteError };

/** The wasm's own: an error of the class that is called `kind`. */
export function made(kind, message, path, field, problem, cure) {
  return new (classes[kind] ?? SuppleError)(message, { path, field, problem, cure });
}

/** The wasm's own: a panic is a fault of the package. */
export function panicked(message) {
  console.error(`supple: ${message}`);
}

/** An error as a message between threads has it, and back. */
export function packed(error) {
  const { name, message, path, field, problem, cure } = error;
  return { name, message, path, field, problem, cure };
}
export function unpacked({ name, message, path, field, problem, cure }) {
  return made(name, message, path, field, problem, cure);
}
