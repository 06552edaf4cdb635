# Loads the tables beside this file into the data frames `responses`, `participants` and `stimuli`:
# Rscript load.R, or source("load.R"). Types, factor levels, labels and units are those of codebook.csv.
# STUDY

read_text <- function(file) {
  read.csv(file.path(folder, file), colClasses = "character", na.strings = "", encoding = "UTF-8",
           check.names = FALSE)
}

# Where this file lies, whether it is sourced or run by Rscript.
find_folder <- function() {
  run <- sub("^--file=", "", grep("^--file=", commandArgs(FALSE), value = TRUE))
  sourced <- Filter(Negate(is.null), lapply(sys.frames(), function(frame) frame$ofile))
  file <- gsub("~+~", " ", c(rev(unlist(sourced)), run), fixed = TRUE)
  file <- file[file.exists(file)]
  if (length(file) > 0) dirname(normalizePath(file[1])) else getwd()
}

# R has no integers of 64 bits: what it could not keep exactly stays text.
as_whole_number <- function(text) {
  digits <- max(0, nchar(text), na.rm = TRUE)
  if (digits <= 9) as.integer(text) else if (digits <= 15) as.numeric(text) else text
}

lines_of <- function(text) if (is.na(text)) character() else strsplit(text, "\n", fixed = TRUE)[[1]]

# A column with the type that its row of the codebook says. Its attributes are `label`, `unit` and, of a
# factor, `labels`: its levels, named by what they mean.
convert <- function(text, about) {
  levels <- lines_of(about$levels)
  if (length(levels) > 0) {
    column <- factor(text, levels = levels)
    attr(column, "labels") <- setNames(levels, lines_of(about$labels))
  } else {
    column <- switch(about$type,
      integer = as_whole_number(text),
      number = as.numeric(text),
      boolean = text == "true",
      datetime = as.POSIXct(text, format = "%Y-%m-%dT%H:%M:%OSZ", tz = "UTC"),
      text)
  }
  attr(column, "label") <- about$description
  if (!is.na(about$unit)) attr(column, "unit") <- about$unit
  column
}

load_table <- function(file) {
  table <- read_text(file)
  about <- codebook[codebook$file == file, ]
  for (row in seq_len(nrow(about))) {
    name <- about$variable[row]
    table[[name]] <- convert(table[[name]], about[row, ])
  }
  table
}

folder <- find_folder()
codebook <- read_text("codebook.csv")
responses <- load_table("responses.csv")
participants <- load_table("participants.csv")
stimuli <- load_table("stimuli.csv")

# What there is now.
local({
  cat("answers:", as.character(responses$study_kind[1]), "\n")
  for (name in c("responses", "participants", "stimuli")) {
    data <- get(name)
    types <- table(vapply(data, function(column) class(column)[1], ""))
    cat(name, ": ", nrow(data), " rows, ", ncol(data), " columns (",
        paste(types, names(types), collapse = ", "), ")\n", sep = "")
  }
  print(table(kind = responses$kind, counts = responses$counts))
})
