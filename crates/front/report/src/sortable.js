// Makes the headings of a table buttons that sort its rows: numbers by value, texts by letters, empty cells last.
function sortable(table) {
  if (table.dataset.sortable) return;
  table.dataset.sortable = "yes";
  const headings = [...table.tHead.rows[0].cells];
  headings.forEach((heading, column) => {
    const button = document.createElement("button");
    button.type = "button";
    button.textContent = heading.textContent;
    heading.textContent = "";
    heading.append(button);
    button.addEventListener("click", () => {
      const rises = heading.getAttribute("aria-sort") !== "ascending";
      headings.forEach((other) => other.removeAttribute("aria-sort"));
      heading.setAttribute("aria-sort", rises ? "ascending" : "descending");
      const body = table.tBodies[0];
      const rows = [...body.rows].map((row) => ({ row, text: row.cells[column].textContent.trim() }));
      rows.sort((a, b) => compare(a.text, b.text, rises ? 1 : -1));
      body.append(...rows.map(({ row }) => row));
    });
  });

  function compare(a, b, sign) {
    if (a === "" || b === "") return (a === "") - (b === "");
    const [x, y] = [a, b].map((text) => Number(text.replaceAll("\u2009", "").replaceAll("\u2212", "-")));
    return sign * (Number.isNaN(x) || Number.isNaN(y) ? a.localeCompare(b) : x - y);
  }
}
